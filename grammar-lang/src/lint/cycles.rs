//! Which nodes of a directed graph come back to themselves.

/// Whether each node lies on a cycle of several nodes. `ways` are the nodes that each leads to.
pub(super) fn on_cycles(ways: &[Vec<usize>]) -> Vec<bool> {
    let mut back: Vec<Vec<usize>> = vec![Vec::new(); ways.len()];
    for (from, to) in ways.iter().enumerate().flat_map(|(from, all)| all.iter().map(move |to| (from, *to))) {
        if let Some(back) = back.get_mut(to) {
            back.push(from);
        }
    }
    // Those from which a node of a cycle is reached both ways are left last, one cycle after the other.
    let mut seen = vec![false; ways.len()];
    let mut order: Vec<usize> = Vec::new();
    for start in 0..ways.len() {
        order.extend(left_from(start, ways, &mut seen));
    }
    let mut seen = vec![false; ways.len()];
    let mut cyclic = vec![false; ways.len()];
    for start in order.into_iter().rev() {
        let together = left_from(start, &back, &mut seen);
        for node in together.iter().filter(|_| together.len() > 1) {
            if let Some(cyclic) = cyclic.get_mut(*node) {
                *cyclic = true;
            }
        }
    }
    cyclic
}

/// The nodes that a walk in depth from a node comes to, in the order in which it leaves them.
fn left_from(start: usize, ways: &[Vec<usize>], seen: &mut [bool]) -> Vec<usize> {
    let mut first = |node: usize| seen.get_mut(node).is_some_and(|seen| !std::mem::replace(seen, true));
    let mut left = Vec::new();
    let mut open: Vec<(usize, usize)> = Vec::new();
    if first(start) {
        open.push((start, 0));
    }
    while let Some((node, next)) = open.last_mut() {
        let to = ways.get(*node).and_then(|ways| ways.get(*next)).copied();
        *next += 1;
        match to {
            Some(to) if first(to) => open.push((to, 0)),
            Some(_) => {}
            None => {
                left.push(*node);
                open.pop();
            }
        }
    }
    left
}

#[cfg(test)]
mod tests {
    use super::on_cycles;

    #[test]
    fn what_leads_to_a_cycle_or_from_one_to_another_is_on_none() {
        // 0 leads to 1, 2, 3, which are a circle; 3 leads to 4, and that to 5 and 6, which are another.
        let ways = [vec![1], vec![2], vec![3], vec![1, 4], vec![5], vec![6], vec![5, 7], vec![]];
        assert_eq!(on_cycles(&ways), [false, true, true, true, false, true, true, false]);
    }
}
