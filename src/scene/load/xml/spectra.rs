//! Constants of colour: `<rgb>`, `<float>` and uniform `<spectrum>`.

use super::super::super::SceneError;
use super::super::fields::{Allowed, FRACTION, NON_NEGATIVE};
use super::element::Element;
use super::object::Object;
use super::transform::numbers;
use crate::math::Rgb;

impl Object<'_> {
    /// A share of light for each channel: a constant, or the largest values of a picture.
    pub fn reflectance(&self, name: &str, default: f32) -> Result<Rgb, SceneError> {
        match self.picture(name)? {
            Some(texture) => Ok(self.color_picture(texture)),
            None => self.color(name, Rgb::splat(default), &FRACTION),
        }
    }

    /// A radiance, an intensity or the like.
    pub fn light(&self, name: &str, default: f32) -> Result<Rgb, SceneError> {
        self.color(name, Rgb::splat(default), &NON_NEGATIVE)
    }

    /// A constant colour; `default` where there is none.
    pub fn color(&self, name: &str, default: Rgb, allowed: &Allowed) -> Result<Rgb, SceneError> {
        let Some(property) = self.take(name) else { return Ok(default) };
        let label = self.element.label();
        let told = |reason: String| property.error(format!("{label}: `{name}` {reason}"));
        if !["rgb", "spectrum", "float", "integer"].contains(&property.tag.as_str()) {
            let reason = format!("{label}: `{name}` is a {}, which is not supported", property.label());
            self.context.unsupported(
                property,
                &reason,
                &format!("the picture has the constant {default} instead"),
            )?;
            return Ok(default);
        }
        let color = constant(property)?;
        match color.to_array().into_iter().find(|&x| !(allowed.holds)(f64::from(x))) {
            None => Ok(color),
            Some(x) => Err(told(format!("is {x}; allowed: {}", allowed.text))),
        }
    }

    /// Refuses a colour other than white, which the core has no word for.
    pub fn only_white(&self, name: &str) -> Result<(), SceneError> {
        let Some(property) = self.element.children.iter().find(|c| c.attribute("name") == Some(name)) else {
            return Ok(());
        };
        if self.color(name, Rgb::ONE, &NON_NEGATIVE)? == Rgb::ONE {
            return Ok(());
        }
        let reason = format!("{}: `{name}` other than 1 is not supported", self.element.label());
        self.context.unsupported(property, &reason, "the picture has 1 instead")
    }
}

fn constant(property: &Element) -> Result<Rgb, SceneError> {
    property.only(&["name", "value"])?;
    let value = property.required("value", "a number, or three for <rgb>; no wavelengths, no file")?;
    if property.tag == "spectrum" && value.contains(':') {
        let reason = "<spectrum> of wavelengths is not supported; allowed: one value, or an <rgb>";
        return Err(property.error(reason));
    }
    match (numbers(property, value)?[..].as_ref(), property.tag.as_str()) {
        (&[all], _) => Ok(Rgb::splat(all as f32)),
        (&[r, g, b], "rgb") => Ok(Rgb::new(r as f32, g as f32, b as f32)),
        (several, tag) => {
            let allowed = if tag == "rgb" { "1 or 3" } else { "1" };
            Err(property.error(format!("<{tag}> of {} numbers; allowed: {allowed}", several.len())))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{fails, good};
    use crate::math::Rgb;

    fn point(intensity: &str) -> String {
        format!("<emitter type=\"point\">\n{intensity}</emitter>")
    }

    #[test]
    fn constants_come_in_several_forms() {
        for (text, expected) in [
            ("", Rgb::ONE),
            ("<rgb name='intensity' value='1, 2 3'/>", Rgb::new(1., 2., 3.)),
            ("<rgb name='intensity' value='0.5'/>", Rgb::splat(0.5)),
            ("<spectrum name='intensity' value='7'/>", Rgb::splat(7.)),
            ("<float name='intensity' value='8'/>", Rgb::splat(8.)),
        ] {
            assert_eq!(good(&point(text), &[]).point_lights[0].intensity, expected, "{text}");
        }
    }

    #[test]
    fn what_is_no_constant_is_refused() {
        for (text, words) in [
            ("<rgb name='intensity' value='1 2'/>", "<rgb> of 2 numbers; allowed: 1 or 3"),
            ("<rgb name='intensity' value='#ff00ff'/>", "`#ff00ff`; allowed: a finite number"),
            (
                "<rgb name='intensity' value='1 2 -3'/>",
                "emitter `point`: `intensity` is -3; allowed: a finite number, 0 or above",
            ),
            ("<rgb name='intensity' value='1 2 1e39'/>", "is inf; allowed"),
            (
                "<spectrum name='intensity' value='400:1, 700:2'/>",
                "<spectrum> of wavelengths is not supported",
            ),
            ("<spectrum name='intensity' filename='a.spd'/>", "unknown attribute `filename`"),
            ("<string name='intensity' value='1'/>", "`intensity` is a string, which is not supported"),
        ] {
            fails(&point(text), 8, words);
        }
    }
}
