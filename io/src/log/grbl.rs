//! What grbl, `grblHAL` and `FluidNC` report of probing: `[PRB:1.000,2.000,-3.000:1]`.

use crate::{InputError, Units, source::Source};

use super::{
    Fault, Importer, LoggedPoint, Reader,
    scan::{self, Scanner, lines},
};

pub(super) const IMPORTER: Importer = Importer {
    name: "grbl",
    summary: "grbl, grblHAL and FluidNC: [PRB:x,y,z:1] in what the control sent",
    about: "A point is a report [PRB:x,y,z:1], anywhere on a line; points have rows, no names. They are in machine \
            coordinates. The unit is that of setting $13, where the log has that line ($13=0 mm, $13=1 inch); state \
            `units` otherwise. A report that ends in :0 is of a probe that missed, and is refused.",
    extensions: &[],
    units: None,
    frame: Some("machine coordinates"),
    reference: "grbl v1.1, Interface: the message [PRB:]; Settings: $13, report in inches.",
    tip_centres: true,
    reader: Reader::Record(read),
};

fn read(source: &Source) -> Result<Vec<LoggedPoint>, InputError> {
    const REPORT: &str = "[PRB:";
    let text = source.text();
    let (mut points, mut units) = (Vec::new(), None);
    for line in lines(text) {
        // Sent or reported, the last one counts.
        if let Some(at) = text[line.clone()].rfind("$13=") {
            units = match text.as_bytes()[line.start + at..line.end].get(4) {
                Some(b'0') => Some(Units::Millimetre),
                Some(b'1') => Some(Units::Inch),
                _ => None,
            };
        }
        for (at, _) in text[line.clone()].match_indices(REPORT) {
            let start = line.start + at;
            let mut scanner = Scanner::new(text, start + REPORT.len()..line.end);
            let mut numbers = vec![scanner.token()];
            while scanner.eat(',') {
                numbers.push(scanner.token());
            }
            let flag = scanner.eat(':').then(|| scanner.token());
            let (true, Some(flag), [x, y, z, ..]) = (scanner.eat(']'), flag, numbers.as_slice()) else {
                let message = "a probe report that is not whole; expected [PRB:x,y,z:1]";
                return Err(InputError::new("invalid-input", message).at(source.place(start..scanner.at())));
            };
            let whole = numbers.iter().all(|number| !text[number.clone()].contains('.'));
            let position = match &text[flag.clone()] {
                "1" if whole && numbers.len() > 3 => Err(Fault::new(
                    "no number has a decimal point: are these decimal commas?",
                    start..scanner.at(),
                )),
                "1" => scan::point(text, [x.clone(), y.clone(), z.clone()]),
                "0" => Err(Fault::new(
                    "the probe missed (flag 0): the position is where it stopped, no touch",
                    flag,
                )),
                other => Err(Fault::new(
                    format!("the flag is `{other}`; expected 1, or 0 for a missed probe"),
                    flag,
                )),
            };
            points.push(LoggedPoint { units, ..LoggedPoint::new(None, start..scanner.at(), position) });
        }
    }
    Ok(points)
}
