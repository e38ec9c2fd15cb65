//! Every combination of values: one job becomes many.

/// A flag and the values that it takes in turn.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// The flag of `caustica render` without its dashes.
    pub flag: String,
    /// As the user wrote them.
    pub values: Vec<String>,
}

impl Axis {
    /// Of `alpha=.5,.7`.
    ///
    /// # Errors
    /// What is wrong with it, and what is allowed.
    pub fn parse(text: &str) -> Result<Axis, String> {
        let (flag, values) = text.split_once('=').unwrap_or((text, ""));
        let values: Vec<String> = values.split(',').map(|value| value.trim().to_owned()).collect();
        if flag.is_empty() || values.iter().any(String::is_empty) {
            return Err(format!("`{text}` is no FLAG=VALUE,VALUE.. such as alpha=.5,.7"));
        }
        Ok(Axis { flag: normal(flag), values })
    }
}

/// Flags may be written as fields of scenes are: `target_error` for `target-error`.
pub(super) fn normal(flag: &str) -> String {
    flag.trim().trim_start_matches("--").replace('_', "-")
}

/// One value of each axis, for every combination; the last axis changes fastest. No axes have one combination, of nothing.
pub fn products(axes: &[Axis]) -> Vec<Vec<(&str, &str)>> {
    let mut products = vec![Vec::new()];
    for axis in axes {
        let with =
            |product: &Vec<(_, _)>, value| [product.clone(), vec![(axis.flag.as_str(), value)]].concat();
        products = products
            .iter()
            .flat_map(|product| axis.values.iter().map(move |value| with(product, value.as_str())))
            .collect();
    }
    products
}

/// What tells a combination from the others: the values of the axes that have more than one.
pub fn suffix(axes: &[Axis], product: &[(&str, &str)]) -> String {
    let changes = |flag: &str| axes.iter().any(|axis| axis.flag == flag && axis.values.len() > 1);
    let told = product.iter().filter(|(flag, _)| changes(flag));
    told.map(|(flag, value)| format!("_{flag}={}", as_file_name(value))).collect()
}

/// Without what file names and shells take for something else.
fn as_file_name(value: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "._+%-=,".contains(c);
    value.chars().map(|c| if is_plain(c) { c } else { '-' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    fn axis(text: &str) -> Axis {
        Axis::parse(text).unwrap()
    }

    #[test]
    fn every_combination_comes_once_and_says_its_values() {
        let axes = [axis("alpha=.5,.7"), axis("radius_policy=fixed"), axis("--photons=1e5, 1e6")];
        let names: Vec<String> = products(&axes).iter().map(|product| suffix(&axes, product)).collect();
        let expected = [
            "_alpha=.5_photons=1e5",
            "_alpha=.5_photons=1e6",
            "_alpha=.7_photons=1e5",
            "_alpha=.7_photons=1e6",
        ];
        assert_eq!(names, expected);
        assert!(products(&axes).iter().all(|product| product[1] == ("radius-policy", "fixed")));
        assert_eq!(products(&[]), [vec![]]);
        assert_eq!(suffix(&[axis("define=a=x/y z,b")], &[("define", "a=x/y z")]), "_define=a=x-y-z");
    }

    #[test]
    fn what_is_no_axis_is_told() {
        for wrong in ["alpha", "alpha=", "=1", "alpha=.5,,.7", ""] {
            assert!(Axis::parse(wrong).unwrap_err().contains("is no FLAG=VALUE,VALUE"), "{wrong}");
        }
    }

    proptest! {
        #[test]
        fn there_are_as_many_as_the_sizes_multiply_to(sizes in prop::collection::vec(1usize..5, 0..4)) {
            let axes: Vec<Axis> = sizes.iter().enumerate().map(|(k, &n)| Axis {
                flag: format!("f{k}"),
                values: (0..n).map(|v| v.to_string()).collect(),
            }).collect();
            let products = products(&axes);
            prop_assert_eq!(products.len(), sizes.iter().product::<usize>());
            let names: BTreeSet<String> = products.iter().map(|product| suffix(&axes, product)).collect();
            prop_assert_eq!(names.len(), products.len());
        }
    }
}
