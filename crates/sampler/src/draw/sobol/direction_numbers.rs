//! Direction numbers of Joe and Kuo.

/// Dimensions that have direction numbers.
pub(super) const MAX_DIMENSIONS: usize = 32;

/// Binary digits of an index, and of the direction numbers.
pub(super) const INDEX_BITS: usize = 32;

/// For each dimension from the second on: the inner coefficients of the primitive polynomial (the highest in the
/// highest bit) and the initial direction numbers `m_1, m_2, ...`, as many as the degree of the polynomial.
const JOE_KUO: [(u32, &[u32]); MAX_DIMENSIONS - 1] = [
    (0, &[1]),
    (1, &[1, 3]),
    (1, &[1, 3, 1]),
    (2, &[1, 1, 1]),
    (1, &[1, 1, 3, 3]),
    (4, &[1, 3, 5, 13]),
    (2, &[1, 1, 5, 5, 17]),
    (4, &[1, 1, 5, 5, 5]),
    (7, &[1, 1, 7, 11, 19]),
    (11, &[1, 1, 5, 1, 1]),
    (13, &[1, 1, 1, 3, 11]),
    (14, &[1, 3, 5, 5, 31]),
    (1, &[1, 3, 3, 9, 7, 49]),
    (13, &[1, 1, 1, 15, 21, 21]),
    (16, &[1, 3, 1, 13, 27, 49]),
    (19, &[1, 1, 1, 15, 7, 5]),
    (22, &[1, 3, 1, 15, 13, 25]),
    (25, &[1, 1, 5, 5, 19, 61]),
    (1, &[1, 3, 7, 11, 23, 15, 103]),
    (4, &[1, 3, 7, 13, 13, 15, 69]),
    (7, &[1, 1, 3, 13, 7, 35, 63]),
    (8, &[1, 3, 5, 9, 1, 25, 53]),
    (14, &[1, 3, 1, 13, 9, 35, 107]),
    (19, &[1, 3, 1, 5, 27, 61, 31]),
    (21, &[1, 1, 5, 11, 19, 41, 61]),
    (28, &[1, 3, 5, 3, 3, 13, 69]),
    (31, &[1, 1, 7, 13, 1, 19, 1]),
    (32, &[1, 3, 7, 5, 13, 19, 59]),
    (37, &[1, 1, 3, 9, 25, 29, 41]),
    (41, &[1, 3, 5, 13, 23, 1, 55]),
    (42, &[1, 3, 7, 3, 13, 59, 17]),
];

/// The columns of `V` of one dimension, the first digit in the highest bit.
///
/// Column `k` is `m_k 2^(32-k)`. Beyond the initial ones, `m_k` follows from the recurrence of the polynomial
/// `x^s + a_1 x^(s-1) + ... + a_(s-1) x + 1`: `m_k = 2 a_1 m_(k-1) ^ ... ^ 2^s m_(k-s) ^ m_(k-s)`.
pub(super) fn direction_numbers(dimension: usize) -> [u32; INDEX_BITS] {
    let mut columns = [0; INDEX_BITS];
    let Some((coefficients, initial)) = dimension.checked_sub(1).map(|row| JOE_KUO[row]) else {
        // The first dimension mirrors the digits of the index (van der Corput).
        return std::array::from_fn(|k| 1 << (INDEX_BITS - 1 - k));
    };
    let degree = initial.len();
    for k in 0..INDEX_BITS {
        columns[k] = if k < degree {
            initial[k] << (INDEX_BITS - 1 - k)
        } else {
            let mut column = columns[k - degree] ^ (columns[k - degree] >> degree);
            for i in 1..degree {
                if coefficients >> (degree - 1 - i) & 1 == 1 {
                    column ^= columns[k - i];
                }
            }
            column
        };
    }
    columns
}
