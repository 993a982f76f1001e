//! Classes of CT in Hounsfield units: skin, soft tissue, bone.

use super::classes::Class;

/// Colours of skin, soft tissue and bone.
pub const COLORS: [[f64; 3]; 3] = [[0.84, 0.62, 0.50], [0.66, 0.27, 0.22], [0.86, 0.79, 0.62]];

/// Skin is a shell between air and tissue. Muscles and organs lie around 50 HU, cancellous bone from 150 and compact bone above 500.
pub fn classes() -> [Class; 3] {
    let skin = vec![(-420.0, 0.0), (-260.0, 1.0), (-120.0, 0.1), (-40.0, 0.0)];
    let soft = vec![(-10.0, 0.0), (40.0, 1.0), (100.0, 1.0), (160.0, 0.0)];
    let bone = vec![(130.0, 0.0), (320.0, 1.0), (3000.0, 1.0)];
    [
        Class { colored: (-1024.0, -40.0), core: (-150.0, -30.0), solid: skin.clone(), shell: skin },
        Class { colored: (-40.0, 140.0), core: (0.0, 120.0), solid: soft.clone(), shell: soft },
        Class { colored: (140.0, 3000.0), core: (220.0, 40000.0), solid: bone.clone(), shell: bone },
    ]
}
