use crate::shard;

/// Numbers in rising order as batch systems list them: `0,3-5`.
pub fn array_list(numbers: &[u32]) -> String {
    let runs = numbers.chunk_by(|a, b| a + 1 == *b);
    shard::array_list(runs.filter_map(|run| Some(*run.first()?..=*run.last()?)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn runs_are_joined() {
        assert_eq!(array_list(&[0, 3, 4, 5, 7, 8]), "0,3-5,7-8");
    }

    proptest! {
        #[test]
        fn lists_hold_their_numbers(numbers in prop::collection::btree_set(0u32..60, 0..40)) {
            let numbers: Vec<u32> = numbers.into_iter().collect();
            let list = array_list(&numbers);
            let number = |text: &str| text.parse::<u32>().unwrap();
            let read: Vec<u32> = list
                .split(',')
                .filter(|part| !part.is_empty())
                .flat_map(|part| match part.split_once('-') {
                    Some((first, last)) => number(first)..=number(last),
                    None => number(part)..=number(part),
                })
                .collect();
            prop_assert_eq!(read, numbers);
        }
    }
}
