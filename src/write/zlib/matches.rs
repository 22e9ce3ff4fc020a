//! Finds repeats: where bytes have stood before, at most 32 KiB back.
//!
//! Bytes, a level -> tokens. A hash of the next four bytes leads to the last place where they stood, and from there to the
//! places before it; the longest repeat wins, the nearest of equal ones. From level 4 on a repeat is put off by a byte
//! where a longer one begins there. The insides of the longest repeats, as long runs of one flag have them, are not looked
//! up later: what repeats begins where flags change.
//!
//! Source: RFC 1951, section 4. Cost: two tables of 128 KiB.

/// Shortest and longest repeat.
pub(super) const MIN: usize = 4;
pub(super) const MAX: usize = 258;
/// Places are remembered for so many bytes; a power of two.
const WINDOW: usize = 1 << 15;
const HASH_BITS: u32 = 15;
/// Marks the token of a repeat: its length - 3 in 8 bits, its distance - 1 in 15.
const REPEAT: u32 = 1 << 31;

/// What comes next: a byte as it is, or bytes that stood before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Token {
    Byte(u8),
    /// Length and distance.
    Repeat(u32, u32),
}

impl Token {
    pub(super) fn pack(self) -> u32 {
        match self {
            Token::Byte(byte) => byte.into(),
            Token::Repeat(length, distance) => REPEAT | (length - 3) << 15 | (distance - 1),
        }
    }

    pub(super) fn unpack(packed: u32) -> Token {
        if packed < REPEAT {
            return Token::Byte(packed as u8);
        }
        Token::Repeat((packed >> 15 & 0xff) + 3, (packed & 0x7fff) + 1)
    }
}

/// The search, and how far it has come.
pub(super) struct Matches<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Places looked at for one repeat.
    most_places: u32,
    /// A repeat of this length is not improved.
    enough: usize,
    is_lazy: bool,
    /// Last place + 1 of every hash, 0 for none; place + 1 before each place.
    last: Vec<u32>,
    before: Vec<u32>,
    /// First place that is not in the tables.
    next: usize,
    /// A repeat that was found while looking further.
    ahead: Option<(usize, usize)>,
}

impl<'a> Matches<'a> {
    /// Starts at the first byte; level 1 to 9.
    pub(super) fn new(bytes: &'a [u8], level: u8) -> Matches<'a> {
        let step = u32::from(level.clamp(1, 9)) - 1;
        Matches {
            bytes,
            at: 0,
            most_places: 2 << step,
            enough: (32 << step).min(MAX),
            is_lazy: level >= 4,
            last: vec![0; 1 << HASH_BITS],
            before: vec![0; WINDOW],
            next: 0,
            ahead: None,
        }
    }

    /// Enters a place in the tables; returns the one before it of the same hash, + 1.
    fn enter(&mut self, at: usize) -> u32 {
        let Some(word) = self.bytes.get(at..at + 4) else { return 0 };
        if at < self.next {
            return self.before[at % WINDOW];
        }
        self.next = at + 1;
        let word = u32::from_le_bytes([word[0], word[1], word[2], word[3]]);
        let last = &mut self.last[(word.wrapping_mul(0x9e37_79b1) >> (32 - HASH_BITS)) as usize];
        self.before[at % WINDOW] = *last;
        std::mem::replace(last, at as u32 + 1)
    }

    /// Length and distance of the longest repeat at a place; a length below [`MIN`] is none.
    fn longest(&mut self, at: usize) -> (usize, usize) {
        let most = (self.bytes.len() - at).min(MAX);
        let mut place = self.enter(at) as usize;
        let mut best = (MIN - 1, 0);
        for _ in 0..self.most_places {
            // a place a whole window back has given up its entry
            if place == 0 || at + 1 - place >= WINDOW || most < MIN {
                break;
            }
            let start = place - 1;
            if best.0 >= most {
                break;
            }
            if self.bytes[start + best.0] == self.bytes[at + best.0] {
                let length = common(&self.bytes[start..start + most], &self.bytes[at..at + most]);
                if length > best.0 {
                    best = (length, at - start);
                    if length >= self.enough {
                        break;
                    }
                }
            }
            place = self.before[start % WINDOW] as usize;
        }
        best
    }
}

impl Iterator for Matches<'_> {
    type Item = Token;

    fn next(&mut self) -> Option<Token> {
        let &byte = self.bytes.get(self.at)?;
        let (length, distance) = match self.ahead.take() {
            Some(found) => found,
            None => self.longest(self.at),
        };
        if length < MIN {
            self.at += 1;
            return Some(Token::Byte(byte));
        }
        if self.is_lazy && length < self.enough && self.at + 1 < self.bytes.len() {
            let later = self.longest(self.at + 1);
            if later.0 > length {
                self.ahead = Some(later);
                self.at += 1;
                return Some(Token::Byte(byte));
            }
        }
        let end = self.at + length;
        let first = if length < MAX { self.at + 1 } else { end - MIN };
        for at in first..end {
            self.enter(at);
        }
        self.at = end;
        Some(Token::Repeat(length as u32, distance as u32))
    }
}

/// Number of equal bytes at the front of two stretches of the same length.
fn common(one: &[u8], other: &[u8]) -> usize {
    let mut n = 0;
    for (a, b) in one.as_chunks::<8>().0.iter().zip(other.as_chunks::<8>().0) {
        let difference = u64::from_le_bytes(*a) ^ u64::from_le_bytes(*b);
        if difference != 0 {
            return n + difference.trailing_zeros() as usize / 8;
        }
        n += 8;
    }
    n + one[n..].iter().zip(&other[n..]).take_while(|(a, b)| a == b).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn expand(tokens: impl Iterator<Item = Token>) -> Vec<u8> {
        let mut bytes: Vec<u8> = Vec::new();
        for token in tokens {
            match token {
                Token::Byte(byte) => bytes.push(byte),
                Token::Repeat(length, distance) => {
                    for _ in 0..length {
                        bytes.push(bytes[bytes.len() - distance as usize]);
                    }
                }
            }
        }
        bytes
    }

    #[test]
    fn tokens_stand_for_the_bytes() {
        let text: Vec<u8> = (0..70_000u32).map(|i| (i.wrapping_mul(i) / 77 % 13 * (i / 300 % 3)) as u8).collect();
        for level in 1..=9 {
            for bytes in [&text[..], &text[..5], &[7; 1000], b"abcdabcdabcde", b""] {
                let tokens = Matches::new(bytes, level).map(|token| Token::unpack(token.pack()));
                assert_eq!(expand(tokens), bytes, "level {level}");
            }
        }
    }

    #[test]
    fn a_run_is_one_byte_and_repeats_of_it() {
        let tokens: Vec<Token> = Matches::new(&[5; 1 + 258 + 10], 1).collect();
        assert_eq!(tokens, [Token::Byte(5), Token::Repeat(258, 1), Token::Repeat(10, 1)]);
        let tokens: Vec<Token> = Matches::new(&[5; 4], 9).collect();
        assert_eq!(tokens, [Token::Byte(5); 4]);
    }

    #[test]
    fn no_repeat_reaches_further_back_than_the_window() {
        let mut bytes = b"0123456789".to_vec();
        bytes.extend(vec![b'-'; WINDOW]);
        bytes.extend(b"0123456789");
        let far = |token: &Token| matches!(token, Token::Repeat(_, distance) if *distance as usize > WINDOW);
        assert!(!Matches::new(&bytes, 9).any(|token| far(&token)));
        assert_eq!(expand(Matches::new(&bytes, 9)), bytes);
    }
}
