// Ascending sort of a stretch of `events` by one thread: insertion for short stretches, heap sort for long ones, so that a
// ray through ten thousand plates costs n log n, not n squared.

const SHORT: u32 = 24u;

fn sort(start: u32, n: u32) {
    if n <= SHORT {
        insertion_sort(start, n);
    } else {
        heap_sort(start, n);
    }
}

fn insertion_sort(start: u32, n: u32) {
    for (var i = 1u; i < n; i++) {
        let value = events[start + i];
        var at = i;
        while at > 0u {
            let left = events[start + at - 1u];
            if left <= value {
                break;
            }
            events[start + at] = left;
            at -= 1u;
        }
        events[start + at] = value;
    }
}

fn heap_sort(start: u32, n: u32) {
    for (var root = n / 2u; root > 0u; root--) {
        sift_down(start, root - 1u, n);
    }
    for (var end = n - 1u; end > 0u; end--) {
        let top = events[start];
        events[start] = events[start + end];
        events[start + end] = top;
        sift_down(start, 0u, end);
    }
}

fn sift_down(start: u32, from_root: u32, n: u32) {
    var root = from_root;
    let value = events[start + root];
    loop {
        var child = 2u * root + 1u;
        if child >= n {
            break;
        }
        if child + 1u < n && events[start + child + 1u] > events[start + child] {
            child += 1u;
        }
        if events[start + child] <= value {
            break;
        }
        events[start + root] = events[start + child];
        root = child;
    }
    events[start + root] = value;
}
