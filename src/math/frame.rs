use super::Vec3;

/// An orthonormal, right-handed frame around a unit normal, which is its local z axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Local x.
    pub tangent: Vec3,
    /// Local y.
    pub bitangent: Vec3,
    /// Local z.
    pub normal: Vec3,
}

impl Frame {
    /// The frame around the unit vector `normal`, without a branch at the poles.
    ///
    /// Every field of frames jumps somewhere. This one does where `z = -1/2`, away from the axes, so that a wall along
    /// them keeps its frame, and with it the paths of its photons, whatever the last bits of its normal are.
    ///
    /// # Source
    /// Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
    pub fn around(normal: Vec3) -> Frame {
        let sign = 1f32.copysign(normal.z + 0.5);
        let a = -1.0 / (sign + normal.z);
        let b = normal.x * normal.y * a;
        Frame {
            tangent: Vec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
            bitangent: Vec3::new(b, sign + normal.y * normal.y * a, -normal.y),
            normal,
        }
    }

    /// World coordinates of the local vector `v`.
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        v.x * self.tangent + v.y * self.bitangent + v.z * self.normal
    }

    /// Local coordinates of the world vector `v`.
    pub fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.tangent), v.dot(self.bitangent), v.dot(self.normal))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn frames_are_orthonormal_and_invert(x in -1f32..1.0, y in -1f32..1.0, z in -1f32..1.0) {
            let normal = Vec3::new(x, y, z);
            prop_assume!(normal.length() > 1e-3);
            let frame = Frame::around(normal.normalize());
            prop_assert!((frame.tangent.cross(frame.bitangent) - frame.normal).length() < 1e-5);
            let v = Vec3::new(0.3, -0.5, 0.7);
            prop_assert!((frame.to_local(frame.to_world(v)) - v).length() < 1e-5);
        }
    }

    #[test]
    fn poles_are_exact() {
        for normal in [Vec3::Z, Vec3::NEG_Z] {
            let frame = Frame::around(normal);
            assert_eq!(frame.tangent.cross(frame.bitangent), normal);
        }
    }
}
