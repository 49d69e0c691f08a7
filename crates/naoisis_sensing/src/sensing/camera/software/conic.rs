//! Areas of the image bounded by a conic section: circles on the ground and the outlines of ellipsoids.

/// The area where a u² + b u v + c v² + d u + e v + f is not positive, u and v being the slopes of a ray to the right and
/// down.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Conic {
    a: f64,
    b: f64,
    c: f64,
    d: f64,
    e: f64,
    f: f64,
}

impl Conic {
    /// The area of the rays x = p + u q + v r (each vector in the same frame of three dimensions) for which xᵀ diag(1, 1, -k) x is not
    /// positive.
    pub(super) fn of_cone(p: [f64; 3], q: [f64; 3], r: [f64; 3], k: f64) -> Self {
        Self::of_form([p, q, r], |x, y| x[0] * y[0] + x[1] * y[1] - k * x[2] * y[2])
    }

    /// The area of the rays x = p + u q + v r for which the symmetric bilinear form `form` of x with itself is not positive.
    #[inline]
    pub(super) fn of_form<V: Copy>([p, q, r]: [V; 3], form: impl Fn(V, V) -> f64) -> Self {
        Self {
            a: form(q, q),
            b: 2.0 * form(q, r),
            c: form(r, r),
            d: 2.0 * form(p, q),
            e: 2.0 * form(p, r),
            f: form(p, p),
        }
    }

    /// The spans of u in the row at v: one, or two that extend to infinity.
    #[inline(always)]
    pub(super) fn spans(&self, v: f64) -> [Option<[f64; 2]>; 2] {
        let linear = self.b * v + self.d;
        let constant = (self.c * v + self.e) * v + self.f;
        let discriminant = linear * linear - 4.0 * self.a * constant;
        if discriminant <= 0.0 || self.a == 0.0 {
            let whole = [f64::NEG_INFINITY, f64::INFINITY];
            return [(self.a < 0.0).then_some(whole), None];
        }
        let root = discriminant.sqrt();
        let (one, other) = ((-linear - root) / (2.0 * self.a), (-linear + root) / (2.0 * self.a));
        if self.a > 0.0 {
            [Some([one, other]), None]
        } else {
            [Some([f64::NEG_INFINITY, other]), Some([one, f64::INFINITY])]
        }
    }

    /// The range of v of an ellipse; unlimited for other conics.
    pub(super) fn rows(&self) -> [f64; 2] {
        // The discriminant of the row's quadratic is itself quadratic in v.
        let quadratic = self.b * self.b - 4.0 * self.a * self.c;
        let linear = 2.0 * self.b * self.d - 4.0 * self.a * self.e;
        let constant = self.d * self.d - 4.0 * self.a * self.f;
        let discriminant = linear * linear - 4.0 * quadratic * constant;
        if quadratic >= 0.0 || self.a <= 0.0 {
            return [f64::NEG_INFINITY, f64::INFINITY];
        }
        if discriminant <= 0.0 {
            return [0.0, 0.0];
        }
        let root = discriminant.sqrt();
        [(-linear + root) / (2.0 * quadratic), (-linear - root) / (2.0 * quadratic)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_circle_has_its_rows_and_spans() {
        // (u - 2)² + (v - 3)² <= 25
        let circle = Conic { a: 1.0, b: 0.0, c: 1.0, d: -4.0, e: -6.0, f: 4.0 + 9.0 - 25.0 };
        assert_eq!(circle.rows(), [-2.0, 8.0]);
        assert_eq!(circle.spans(3.0), [Some([-3.0, 7.0]), None]);
        assert_eq!(circle.spans(7.0), [Some([-1.0, 5.0]), None]);
        assert_eq!(circle.spans(8.5), [None, None]);
    }

    #[test]
    fn a_hyperbola_has_two_spans() {
        // u² >= 4
        let conic = Conic { a: -1.0, b: 0.0, c: 0.0, d: 0.0, e: 0.0, f: 4.0 };
        assert_eq!(conic.spans(1.0), [Some([f64::NEG_INFINITY, -2.0]), Some([2.0, f64::INFINITY])]);
    }
}
