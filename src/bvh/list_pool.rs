//! Memory for lists of points, which outlives a gathering: the next one needs as much.

use std::sync::{Mutex, MutexGuard, PoisonError};

use super::point_lists::PointLists;

/// Lists that are not in use, those with the least room first.
#[derive(Debug, Default)]
pub(super) struct ListPool(Mutex<Vec<PointLists>>);

/// Memory is not worth copying: a clone begins without.
impl Clone for ListPool {
    fn clone(&self) -> ListPool {
        ListPool::default()
    }
}

impl ListPool {
    /// Lists with room for `count` points, whatever is in them: the smallest that has it, else new ones.
    pub(super) fn take(&self, count: usize) -> PointLists {
        let mut free = self.free();
        let at = free.partition_point(|lists| lists.room() < count);
        let mut lists = if at < free.len() { free.remove(at) } else { PointLists::default() };
        drop(free);
        lists.make_room(count);
        lists
    }

    /// Keeps lists for others; of equal ones the last comes first, since it may still be in a cache.
    pub(super) fn give_back(&self, lists: PointLists) {
        let mut free = self.free();
        let at = free.partition_point(|other| other.room() < lists.room());
        free.insert(at, lists);
    }

    fn free(&self) -> MutexGuard<'_, Vec<PointLists>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_lists_that_suffice_are_used_again() {
        let pool = ListPool::default();
        let [large, small, middle] = [900, 100, 500].map(|count| pool.take(count));
        let rooms = [&small, &middle, &large].map(PointLists::room);
        assert!(rooms[0] >= 100 && rooms[1] >= 500 && rooms[2] >= 900);
        [large, small, middle].into_iter().for_each(|lists| pool.give_back(lists));
        let room = |count| pool.take(count).room();
        assert_eq!([room(400), room(400), room(10)], [rooms[1], rooms[2], rooms[0]]);
        assert!(pool.free().is_empty() && room(2000) >= 2000);
    }
}
