//! Huffman codes of limited length, in the canonical form that DEFLATE stores as lengths alone.
//!
//! Counts -> lengths of codes -> codes. The lengths are those of the best code; where one is too long, it is cut, and as few
//! others as possible are made longer to pay for it.
//!
//! Source: RFC 1951, section 3.2.2; the two queues of J. van Leeuwen (1976) for the tree.

/// Longest code of bytes, lengths and distances.
pub(super) const MAX_LENGTH: usize = 15;

/// Lengths of the codes of symbols that occur so often, at most `most`; 0 for those that never do. At least two symbols get a
/// code, since a code for one is not complete, and readers differ in what they make of it.
pub(super) fn lengths(counts: &mut [u32], most: usize) -> Vec<u8> {
    let n_used = counts.iter().filter(|&&count| count > 0).count();
    for count in counts.iter_mut().filter(|count| **count == 0).take(2usize.saturating_sub(n_used)) {
        *count = 1;
    }
    // by count, then by symbol: counts of a block have less than 23 bits, symbols 9
    let used = counts.iter().enumerate().filter(|(_, count)| **count > 0);
    let mut leaves: Vec<u32> = used.map(|(symbol, &count)| count << 9 | symbol as u32).collect();
    leaves.sort_unstable();
    let mut n_of_length = depths(&leaves, most);
    // a code of length L takes 2^-L of all; what is too much is given back by the longest codes
    let mut taken: usize = (1..=most).map(|length| n_of_length[length] << (most - length)).sum();
    while taken > 1 << most {
        let shorter = (1..most).rev().find(|&length| n_of_length[length] > 0).unwrap_or(1);
        n_of_length[most] -= 1;
        n_of_length[shorter] -= 1;
        n_of_length[shorter + 1] += 2;
        taken -= 1;
    }
    let mut lengths = vec![0; counts.len()];
    let mut leaves = leaves.iter();
    for length in (1..=most).rev() {
        for leaf in leaves.by_ref().take(n_of_length[length]) {
            lengths[(leaf & 0x1ff) as usize] = length as u8;
        }
    }
    lengths
}

/// Number of leaves at each depth of the best tree, those deeper than `most` at `most`; leaves ascend by count.
fn depths(leaves: &[u32], most: usize) -> [usize; MAX_LENGTH + 1] {
    let n = leaves.len();
    let mut weights: Vec<u32> = leaves.iter().map(|leaf| leaf >> 9).collect();
    let mut parents = vec![0; 2 * n - 1];
    // the two lightest are always next in the queue of leaves or in that of joined nodes
    let (mut leaf, mut node) = (0, n);
    for joined in n..2 * n - 1 {
        let mut weight = 0;
        for _ in 0..2 {
            let is_leaf = leaf < n && (node == joined || weights[leaf] <= weights[node]);
            let lightest = if is_leaf { &mut leaf } else { &mut node };
            weight += weights[*lightest];
            parents[*lightest] = joined;
            *lightest += 1;
        }
        weights.push(weight);
    }
    let mut depths = vec![0; 2 * n - 1];
    let mut n_of_depth = [0; MAX_LENGTH + 1];
    for index in (0..2 * n - 2).rev() {
        depths[index] = depths[parents[index]] + 1;
        if index < n {
            n_of_depth[depths[index].min(most)] += 1;
        }
    }
    n_of_depth
}

/// The codes of symbols with codes of these lengths, their first bit lowest.
pub(super) fn codes(lengths: &[u8]) -> Vec<u16> {
    let mut next = [0u16; MAX_LENGTH + 2];
    for length in 1..=MAX_LENGTH {
        let n_shorter = lengths.iter().filter(|&&other| other > 0 && usize::from(other) == length).count() as u16;
        next[length + 1] = next[length].wrapping_add(n_shorter) << 1;
    }
    let code = |&length: &u8| {
        let code = &mut next[usize::from(length)];
        *code = code.wrapping_add(1);
        (*code - 1).reverse_bits().checked_shr(16 - u32::from(length)).unwrap_or(0)
    };
    lengths.iter().map(code).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lengths_of(counts: &[u32], most: usize) -> Vec<u8> {
        lengths(&mut counts.to_vec(), most)
    }

    #[test]
    fn the_best_code_where_it_is_short_enough() {
        assert_eq!(lengths_of(&[8, 0, 4, 2, 1, 1], 15), [1, 0, 2, 3, 4, 4]);
        assert_eq!(lengths_of(&[3, 3, 3, 3], 15), [2; 4]);
        assert_eq!(lengths_of(&[0, 9, 0], 15), [1, 1, 0]);
        assert_eq!(lengths_of(&[0, 0, 0], 15), [1, 1, 0]);
    }

    #[test]
    fn codes_are_complete_and_as_short_as_allowed() {
        // Fibonacci numbers give the deepest trees
        let mut counts = vec![1u32, 1];
        while counts.len() < 24 {
            counts.push(counts[counts.len() - 1] + counts[counts.len() - 2]);
        }
        for most in [7, 10, 15] {
            let lengths = lengths_of(&counts, most);
            let taken: usize = lengths.iter().map(|&length| 1 << (most - usize::from(length))).sum();
            assert_eq!(taken, 1 << most);
            assert!(lengths.is_sorted_by(|one, next| one >= next), "{lengths:?}");
        }
    }

    #[test]
    fn codes_are_those_of_the_standard() {
        // the example of RFC 1951: A to H with lengths 3 3 3 3 3 2 4 4
        let reversed = [0b010, 0b110, 0b001, 0b101, 0b011, 0b00, 0b0111, 0b1111];
        assert_eq!(codes(&[3, 3, 3, 3, 3, 2, 4, 4]), reversed);
        assert_eq!(codes(&[0, 1, 1]), [0, 0, 1]);
    }
}
