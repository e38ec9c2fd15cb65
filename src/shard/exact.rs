//! Sums of f32 numbers, and of their squares, without any rounding: the same bits in whatever order they are added.

/// A sum as an integer of `64 LIMBS` bits in two's complement, in units of `2^LOWEST`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Exact<const LIMBS: usize, const LOWEST: i32> {
    /// The least first.
    limbs: [u64; LIMBS],
}

/// The least bit of any f32.
const LEAST: i32 = -149;

/// A sum of f32 numbers, which lie in `2^-149 .. 2^128`: 277 bits, 32 for their number and one for the sign, in 40 bytes.
pub type Sum = Exact<5, LEAST>;
/// A sum of squares of f32 numbers, which lie in `2^-298 .. 2^256`: 554 bits and 33, in 80 bytes.
pub type SquareSum = Exact<10, { 2 * LEAST }>;

/// Bits of a limb.
const BITS: u32 = u64::BITS;
/// The sign in the first byte of a packed sum, which is its length otherwise.
const NEGATIVE: u8 = 0x80;

impl<const LIMBS: usize, const LOWEST: i32> Default for Exact<LIMBS, LOWEST> {
    fn default() -> Self {
        Exact { limbs: [0; LIMBS] }
    }
}

impl Sum {
    /// Adds a finite number.
    pub fn add(&mut self, x: f32) {
        let (mantissa, place) = parts(x);
        self.add_bits(mantissa, place, x.is_sign_negative());
    }
}

impl SquareSum {
    /// Adds the square of a finite number.
    pub fn add_square_of(&mut self, x: f32) {
        let (mantissa, place) = parts(x);
        self.add_bits(mantissa * mantissa, 2 * place, false);
    }
}

/// `|x| = m 2^(p - 149)` of a finite number.
fn parts(x: f32) -> (u64, u32) {
    let (exponent, fraction) = (x.to_bits() >> 23 & 0xff, x.to_bits() & 0x7f_ffff);
    let hidden = u32::from(exponent > 0) << 23;
    (u64::from(fraction | hidden), exponent.max(1) - 1)
}

impl<const LIMBS: usize, const LOWEST: i32> Exact<LIMBS, LOWEST> {
    /// Adds `±bits 2^(LOWEST + place)`.
    fn add_bits(&mut self, bits: u64, place: u32, negative: bool) {
        let (limb, shift) = ((place / BITS) as usize, place % BITS);
        let two = u128::from(bits) << shift;
        let two = [two as u64, (two >> BITS) as u64];
        match negative {
            false => add(&mut self.limbs[limb..], &two),
            true => subtract(&mut self.limbs[limb..], &two),
        }
    }

    fn is_negative(&self) -> bool {
        self.limbs[LIMBS - 1] >> (BITS - 1) == 1
    }

    fn magnitude(&self) -> [u64; LIMBS] {
        if !self.is_negative() {
            return self.limbs;
        }
        let mut magnitude = [0; LIMBS];
        subtract(&mut magnitude, &self.limbs);
        magnitude
    }

    /// The nearest f64, of two the even one.
    pub fn to_f64(&self) -> f64 {
        let magnitude = self.magnitude();
        let Some(top) = magnitude.iter().rposition(|&limb| limb != 0) else { return 0.0 };
        // The highest 64 bits, of which the last tells whether there are any below: f64 keeps 53 of them.
        let (shift, below) = (magnitude[top].leading_zeros(), &magnitude[..top]);
        let next = below.last().copied().unwrap_or(0);
        let two = (u128::from(magnitude[top]) << BITS | u128::from(next)) << shift;
        let lost = two as u64 != 0 || below.iter().rev().skip(1).any(|&limb| limb != 0);
        let rounded = ((two >> BITS) as u64 | u64::from(lost)) as f64;
        let scaled = rounded * power_of_two(LOWEST + (BITS * top as u32) as i32 - shift as i32);
        if self.is_negative() { -scaled } else { scaled }
    }

    /// Appends it to `bytes`: length and sign, and if it is not zero the place of its first byte, and those that are not zero
    /// at either end.
    pub fn pack(&self, bytes: &mut Vec<u8>) {
        let magnitude = self.magnitude();
        let all = || magnitude.iter().flat_map(|limb| limb.to_le_bytes());
        let Some(first) = all().position(|byte| byte != 0) else { return bytes.push(0) };
        let zeros = magnitude.iter().rev().flat_map(|limb| limb.to_be_bytes()).take_while(|&byte| byte == 0);
        let length = 8 * LIMBS - first - zeros.count();
        bytes.push(length as u8 | if self.is_negative() { NEGATIVE } else { 0 });
        bytes.push(first as u8);
        bytes.extend(all().skip(first).take(length));
    }

    /// Adds what was packed at the beginning of `bytes`, and leaves what follows; `None` where it is nothing that was packed.
    pub fn add_packed(&mut self, bytes: &mut &[u8]) -> Option<()> {
        let (&head, rest) = bytes.split_first()?;
        let length = usize::from(head & !NEGATIVE);
        if length == 0 {
            *bytes = rest;
            return (head == 0).then_some(());
        }
        let (&first, rest) = rest.split_first()?;
        let (digits, rest) = rest.split_at_checked(length)?;
        let mut limbs = [0u64; LIMBS];
        for (place, &byte) in (usize::from(first)..).zip(digits) {
            *limbs.get_mut(place / 8)? |= u64::from(byte) << (8 * (place % 8));
        }
        match head & NEGATIVE {
            0 => add(&mut self.limbs, &limbs),
            _ => subtract(&mut self.limbs, &limbs),
        }
        *bytes = rest;
        Some(())
    }
}

/// The variance of the mean of `n` numbers, `(n Σ x² - (Σ x)²) / (n² (n - 1))`, of which all but the division is exact; NaN
/// below two.
pub fn variance_of_mean(sum: &Sum, squares: &SquareSum, n: u32) -> f64 {
    if n < 2 {
        return f64::NAN;
    }
    let mut difference = SquareSum { limbs: times(&squares.limbs, &[n.into()]) };
    let magnitude = sum.magnitude();
    subtract(&mut difference.limbs, &times(&magnitude, &magnitude));
    let n = f64::from(n);
    difference.to_f64() / (n * n * (n - 1.0))
}

/// The product of two numbers that are not negative, as far as it has limbs for it.
fn times(a: &[u64], b: &[u64]) -> [u64; 10] {
    let mut product = [0u64; 10];
    for (place, &x) in b.iter().enumerate() {
        let mut carry = 0u128;
        for (limb, &y) in product[place..].iter_mut().zip(a) {
            let step = u128::from(x) * u128::from(y) + u128::from(*limb) + carry;
            (*limb, carry) = (step as u64, step >> BITS);
        }
        if let Some(limb) = product.get_mut(place + a.len()) {
            *limb = carry as u64;
        }
    }
    product
}

/// Adds numbers limb by limb; what is carried beyond the last is lost.
fn add(to: &mut [u64], from: &[u64]) {
    let mut carry = false;
    for (place, limb) in to.iter_mut().enumerate() {
        let Some(&other) = from.get(place).or(carry.then_some(&0)) else { return };
        let (sum, over) = limb.overflowing_add(other);
        let (sum, over_by_carry) = sum.overflowing_add(carry.into());
        (*limb, carry) = (sum, over | over_by_carry);
    }
}

/// The same for differences.
fn subtract(to: &mut [u64], from: &[u64]) {
    let mut borrow = false;
    for (place, limb) in to.iter_mut().enumerate() {
        let Some(&other) = from.get(place).or(borrow.then_some(&0)) else { return };
        let (difference, under) = limb.overflowing_sub(other);
        let (difference, under_by_borrow) = difference.overflowing_sub(borrow.into());
        (*limb, borrow) = (difference, under | under_by_borrow);
    }
}

/// `2^exponent`, for exponents of normal numbers.
fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((exponent + 1023) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn sum_of(numbers: &[f32]) -> Sum {
        let mut sum = Sum::default();
        numbers.iter().for_each(|&x| sum.add(x));
        sum
    }

    fn squares_of(numbers: &[f32]) -> SquareSum {
        let mut sum = SquareSum::default();
        numbers.iter().for_each(|&x| sum.add_square_of(x));
        sum
    }

    /// Any finite bits.
    fn finite() -> impl Strategy<Value = f32> {
        any::<u32>().prop_map(f32::from_bits).prop_filter("finite", |x| x.is_finite())
    }

    /// Multiples of `2^-20` below 8: i128 adds them and their squares without rounding.
    fn tame() -> impl Strategy<Value = f32> {
        (-(1i32 << 23)..1 << 23).prop_map(|k| k as f32 / (1 << 20) as f32)
    }

    #[test]
    fn ends_of_the_range_come_back() {
        let least = f32::from_bits(1);
        for x in [0.0, -0.0, least, -least, f32::MIN_POSITIVE, 1.0, -1.5, f32::MAX, f32::MIN] {
            assert_eq!(sum_of(&[x]).to_f64(), f64::from(x));
            let square = squares_of(&[x]).to_f64();
            assert_eq!(square, f64::from(x) * f64::from(x), "{x:e}");
        }
        let many =
            Sum { limbs: times(&sum_of(&[f32::MAX]).limbs, &[u32::MAX.into()])[..5].try_into().unwrap() };
        assert_eq!(many.to_f64(), f64::from(f32::MAX) * f64::from(u32::MAX));
    }

    /// What f64 would have lost on the way.
    #[test]
    fn nothing_is_lost_between_large_numbers() {
        let least = f32::from_bits(1);
        assert_eq!(sum_of(&[f32::MAX, least, f32::MIN]).to_f64(), f64::from(least));
        assert_eq!(sum_of(&[f32::MIN, f32::MAX, -least, -least]).to_f64(), -2.0 * f64::from(least));
    }

    /// 2^53 + 1 lies between two f64, of which the even one is below; one bit far below decides otherwise.
    #[test]
    fn ties_go_to_even_and_the_last_bit_counts() {
        let large = 2f32.powi(53);
        for (numbers, expected) in [
            (&[large, 1.0][..], 2f64.powi(53)),
            (&[large, 1.0, 2.0], 2f64.powi(53) + 4.0),
            (&[large, 1.0, 1e-40], 2f64.powi(53) + 2.0),
            (&[large, 1.0, -1e-40], 2f64.powi(53)),
            (&[-large, -1.0, -1e-40], -(2f64.powi(53) + 2.0)),
        ] {
            assert_eq!(sum_of(numbers).to_f64(), expected, "{numbers:?}");
        }
    }

    #[test]
    fn variances_do_not_cancel() {
        // Two neighbours: their mean has half their difference as standard error, whatever their size.
        for x in [1.0f32, 1e-30, 3e30] {
            let next = f32::from_bits(x.to_bits() + 1);
            let variance = variance_of_mean(&sum_of(&[x, next]), &squares_of(&[x, next]), 2);
            assert_eq!(variance.sqrt(), 0.5 * (f64::from(next) - f64::from(x)), "{x}");
        }
        assert_eq!(variance_of_mean(&sum_of(&[0.1; 7]), &squares_of(&[0.1; 7]), 7), 0.0);
        assert!(variance_of_mean(&sum_of(&[1.0]), &squares_of(&[1.0]), 1).is_nan());
    }

    proptest! {
        #[test]
        fn order_and_split_do_not_matter(numbers in prop::collection::vec(finite(), 0..30), cut in 0usize..30, seed in any::<u64>()) {
            let mut shuffled = numbers.clone();
            shuffled.sort_by_key(|x| u64::from(x.to_bits()).wrapping_mul(seed | 1));
            let (first, second) = shuffled.split_at(cut.min(shuffled.len()));
            let mut packed = Vec::new();
            sum_of(first).pack(&mut packed);
            squares_of(first).pack(&mut packed);
            let (mut sum, mut squares, mut rest) = (sum_of(second), squares_of(second), packed.as_slice());
            sum.add_packed(&mut rest).unwrap();
            squares.add_packed(&mut rest).unwrap();
            prop_assert_eq!(sum, sum_of(&numbers));
            prop_assert_eq!(squares, squares_of(&numbers));
        }

        #[test]
        fn sums_are_those_of_wide_integers(numbers in prop::collection::vec(tame(), 2..40)) {
            let integers: Vec<i128> = numbers.iter().map(|&x| (f64::from(x) * f64::from(1 << 20)) as i128).collect();
            let (sum, squares) = (integers.iter().sum::<i128>(), integers.iter().map(|k| k * k).sum::<i128>());
            prop_assert_eq!(sum_of(&numbers).to_f64(), sum as f64 * 2f64.powi(-20));
            prop_assert_eq!(squares_of(&numbers).to_f64(), squares as f64 * 2f64.powi(-40));
            let n = numbers.len() as u32;
            let variance = variance_of_mean(&sum_of(&numbers), &squares_of(&numbers), n);
            let n = f64::from(n);
            let exact = (n as i128 * squares - sum * sum) as f64 * 2f64.powi(-40);
            prop_assert_eq!(variance, exact / (n * n * (n - 1.0)));
        }

        #[test]
        fn two_numbers_are_rounded_as_f64_rounds_them(a in finite(), b in finite()) {
            prop_assert_eq!(sum_of(&[a, b]).to_f64(), f64::from(a) + f64::from(b));
        }

        #[test]
        fn what_is_packed_comes_back(numbers in prop::collection::vec(finite(), 0..5), end in prop::collection::vec(any::<u8>(), 0..4)) {
            let (sum, squares) = (sum_of(&numbers), squares_of(&numbers));
            let mut bytes = Vec::new();
            sum.pack(&mut bytes);
            squares.pack(&mut bytes);
            bytes.extend(&end);
            let mut rest = bytes.as_slice();
            let (mut sum_again, mut squares_again) = (Sum::default(), SquareSum::default());
            sum_again.add_packed(&mut rest).unwrap();
            squares_again.add_packed(&mut rest).unwrap();
            prop_assert_eq!((sum_again, squares_again, rest), (sum, squares, end.as_slice()));
        }

        #[test]
        fn nonsense_is_refused_or_a_number(bytes in prop::collection::vec(any::<u8>(), 0..60)) {
            let mut rest = bytes.as_slice();
            if Sum::default().add_packed(&mut rest).is_some() {
                prop_assert!(rest.len() < bytes.len());
            }
        }
    }

    #[test]
    fn zero_takes_one_byte_and_a_plain_number_few() {
        let packed = |sum: &Sum| {
            let mut bytes = Vec::new();
            sum.pack(&mut bytes);
            bytes.len()
        };
        assert_eq!([packed(&sum_of(&[])), packed(&sum_of(&[1.0])), packed(&sum_of(&[0.1; 1000]))], [1, 3, 7]);
    }
}
