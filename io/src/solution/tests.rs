use nalgebra::{Matrix6, Vector3};
use touchref_core::{Frame, SecondMinimum, SigmaSource};

use super::*;

fn solution() -> Solution {
    let twist = Twist { translation: Vector3::x(), rotation: Vector3::zeros() };
    let about = nalgebra::Point3::origin();
    let weakest = Motion::new(twist, about);
    let trust = Trust {
        sigma: None,
        from_sigma: 0.1,
        up_to_sigma: f64::INFINITY,
        limited_by: Limit::None,
        second_minimum: Some(SecondMinimum { chi_square: None, frame: Frame::identity() }),
        nonlinearity: None,
    };
    let observability = Observability { rank: 6, condition: 1.0 / 3.0, weakest };
    let residuals = vec![Residual { length: 0.1 + 0.2, normalized: None }];
    let mut solution = Solution::new("test", Frame::identity(), residuals, trust, observability);
    solution.roots.push(RootReport {
        frame: Frame::identity(),
        measures: vec![Measure { name: "radius".into(), value: 1.2, u: None }],
        misfit: Some(f64::NAN),
        selected: true,
        reason: "the only one".into(),
    });
    solution.covariance = Some(Covariance {
        matrix: Matrix6::identity() / 3.0,
        sigma: 0.5,
        sigma_source: SigmaSource::Residuals,
    });
    solution
}

#[test]
fn json_has_the_stated_keys_and_comes_back_the_same() {
    let measurement = crate::Measurement::new("f", Units::Millimetre).with_parameter("radius", 1.0);
    let touch = TouchRecord::new("plane", nalgebra::Point3::origin());
    let context = Context {
        kind: &measurement.kind,
        parameters: measurement.parameters(),
        units: measurement.units,
        probe: &measurement.probe,
        touches: &[touch],
    };
    let record = SolutionRecord::new(&context, &solution());
    let text = serde_json::to_string(&record).unwrap();
    assert_eq!(serde_json::from_str::<SolutionRecord>(&text).unwrap(), record);
    for part in [
        r#"{"schema":"touchref.solution/1","fixture":{"kind":"f","parameters":{"radius":1.0}},"solver":"test","units":"mm""#,
        r#""touches":[{"index":0,"id":null,"surface":"plane","at":[0.0,0.0,0.0],"residual":0.30000000000000004,"normalized":null}]"#,
        r#""degrees_of_freedom":0,"p_value":null"#,
        r#""order":["x","y","z","rx","ry","rz"],"axes":"parent","about":"origin","sigma":0.5,"sigma_source":"residuals""#,
        r#""measures":{"radius":1.2},"measures_u":{"radius":null},"misfit":null,"selected":true"#,
        r#""trust":{"sigma":null,"from_sigma":0.1,"up_to_sigma":null,"limited_by":"none","second_minimum":{"chi_square":null"#,
        r#""observability":{"rank":6,"condition":0.3333333333333333,"weakest":"slide"#,
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
}
