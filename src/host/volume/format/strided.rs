//! Strided layouts of numbers.

/// Strides in bytes, last axis fastest.
pub(super) fn strides(shape: &[usize], size: usize) -> Vec<usize> {
    let mut strides = vec![size; shape.len()];
    for axis in (1..shape.len()).rev() {
        strides[axis - 1] = strides[axis] * shape[axis];
    }
    strides
}

/// Position of item `n` in a grid of `counts` items, last axis fastest.
pub(super) fn place(mut n: usize, counts: &[usize]) -> Vec<usize> {
    let mut place = vec![0; counts.len()];
    for axis in (0..counts.len()).rev() {
        place[axis] = n % counts[axis];
        n /= counts[axis];
    }
    place
}

/// Copies a box of numbers of `size` bytes between two strided layouts.
pub(super) fn copy(from: &[u8], from_strides: &[usize], to: &mut [u8], to_strides: &[usize], shape: &[usize], size: usize) {
    let ([count, shape @ ..], [step, from_strides @ ..], [stride, to_strides @ ..]) = (shape, from_strides, to_strides) else {
        to[..size].copy_from_slice(&from[..size]);
        return;
    };
    if shape.is_empty() && *step == size && *stride == size {
        to[..count * size].copy_from_slice(&from[..count * size]);
        return;
    }
    for n in 0..*count {
        copy(&from[n * step..], from_strides, &mut to[n * stride..], to_strides, shape, size);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_copied_between_orders() {
        let from: Vec<u8> = (0..24).collect();
        let mut to = vec![0; 24];
        copy(&from, &[12, 4, 1], &mut to, &[1, 2, 6], &[2, 3, 4], 1);
        assert_eq!(to[..8], [0, 12, 4, 16, 8, 20, 1, 13]);
    }
}
