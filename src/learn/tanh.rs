//! The hyperbolic tangent of many numbers at once, by operations that give the same bits everywhere.

/// Beyond this it is 1 in `f32`.
const END: f32 = 7.905_311;
/// A rational function of x, odd over even powers (as in Eigen's `generic_fast_tanh_float`): within five units in the last place.
const ODD: [f32; 7] = [
    4.893_524_6e-3,
    6.372_619_3e-4,
    1.485_722_4e-5,
    5.122_297e-8,
    -8.604_672e-11,
    2.000_188e-13,
    -2.760_768_5e-16,
];
const EVEN: [f32; 4] = [4.893_525e-3, 2.268_434_6e-3, 1.185_347_1e-4, 1.198_258_4e-6];

/// Replaces each number by its hyperbolic tangent.
pub(super) fn tanh(values: &mut [f32]) {
    for value in values {
        let x = value.clamp(-END, END);
        let square = x * x;
        let odd = ODD.iter().rev().fold(0.0, |sum, factor| sum * square + factor);
        let even = EVEN.iter().rev().fold(0.0, |sum, factor| sum * square + factor);
        *value = x * odd / even;
    }
}

#[cfg(test)]
mod tests {
    use super::tanh;

    #[test]
    fn it_is_the_hyperbolic_tangent() {
        for i in -4000..=4000 {
            let x = i as f32 * 0.003;
            let mut one = [x];
            tanh(&mut one);
            assert!((one[0] - libm::tanhf(x)).abs() < 1e-6, "{x}: {}", one[0]);
            assert!(one[0].abs() <= 1.0);
        }
    }
}
