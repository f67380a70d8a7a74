use super::*;
use proptest::prelude::*;

#[test]
fn numbers_and_names_are_plain() {
    let text = |v: f64, decimals: i32| number(v, decimals).to_string();
    assert_eq!([text(2.0, 2), text(-0.004, 2), text(1.25, 1), text(-12.3456, 3)], ["2", "0", "1.3", "-12.346"]);
    assert_eq!(plain_name(" a\nb\u{7} "), "ab");
    assert_eq!(plain_name("\n"), "character");
    assert_eq!(beside(Path::new("x/é.json"), "_tex.png").expect("a name").1, "é_tex.png");
    assert!(beside(Path::new("x/a.png"), ".png").is_err() && beside(Path::new("/"), ".png").is_err());
}

proptest! {
    /// As readers do it: what is told goes to its place, the others fill the rest in their order.
    #[test]
    fn moves_give_the_order_back(order in Just((0..9usize).collect::<Vec<_>>()).prop_shuffle()) {
        let mut read = vec![None; order.len()];
        let moves = parts::moves(&order);
        for &(part, by) in &moves {
            read[(part as i64 + by) as usize] = Some(part);
        }
        let mut others = (0..order.len()).filter(|p| moves.iter().all(|m| m.0 != *p));
        let read: Vec<usize> = read.into_iter().filter_map(|p| p.or_else(|| others.next())).collect();
        prop_assert_eq!(read, order);
    }
}
