//! Tests of valid, wrong and hostile files of rays.

use super::*;

/// Makes a `.npy` file of version 1.
fn npy(descr: &str, order: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

fn problem(bytes: &[u8]) -> String {
    read(bytes).unwrap_err().to_string()
}

#[test]
fn doubles_are_translated_before_they_are_rounded() {
    let row = [-2_487_002.881_739_342, 4_684_683.25, 0.1, 0.0, 0.0, -1.0, 0.0, 1e300];
    let origin = [-2_487_003.0, 4_684_683.0, 0.0];
    let little: Vec<u8> = row.iter().flat_map(|x: &f64| x.to_le_bytes()).collect();
    let big: Vec<u8> = row.iter().flat_map(|x: &f64| x.to_be_bytes()).collect();
    for (descr, data) in [("<f8", little), (">f8", big)] {
        let table = read(&npy(descr, "False", "(1, 8)", &data)).unwrap();
        assert!(table.is_rounded());
        let ray = table.rays(origin)[0].unwrap();
        assert_eq!(ray.origin().to_array(), [0.118_260_66, 0.25, 0.1]);
        assert_eq!(ray.t_max(), f32::INFINITY);
    }
    // Numbers of 32 bits without an origin keep their bits.
    let row = [0.1_f32, -0.0, 3e-45, 1.0, 0.0, 0.0];
    let data: Vec<u8> = row.iter().flat_map(|x| x.to_le_bytes()).collect();
    let table = read(&npy("<f4", "True", "(1, 6)", &data)).unwrap();
    assert!(!table.is_rounded() && !table.is_empty());
    let origin = table.rays([0.0; 3])[0].unwrap().origin().to_array();
    assert_eq!(origin, [0.1, 0.0, 3e-45]);
}

#[test]
fn files_that_are_cut_off_say_so() {
    let whole = npy("<f4", "False", "(2, 6)", &[0; 48]);
    assert_eq!(read(&whole).unwrap().len(), 2);
    let size = whole.len();
    assert_eq!(
        problem(&whole[..size - 1]),
        format!("it is cut off: shape [2, 6] needs {size} bytes, but it has {}", size - 1)
    );
    assert_eq!(problem(&whole[..30]), "the header of the .npy file is not valid: it is cut off");
    assert!(
        problem(&npy("<f8", "False", "(1000000000000, 8)", &[0; 64])).starts_with("it is cut off")
    );
}

#[test]
fn other_files_are_named() {
    let zip = "it is a ZIP archive; if it is .npz, save the one array with numpy.save instead";
    assert_eq!(problem(b"PK\x03\x04rest"), zip);
    assert_eq!(
        problem(b"\x1f\x8b\x08"),
        "it is compressed by gzip; unpack it first, with `gunzip`"
    );
    assert_eq!(problem(b"0 0 1 0 0 -1"), "it is not a .npy file; save the rays with numpy.save");
    assert_eq!(problem(b""), "it is not a .npy file; save the rays with numpy.save");
    assert_eq!(
        problem(&npy("<i8", "False", "(1, 6)", &[0; 48])),
        "it holds values of type '<i8'; rays are float32 or float64: save it with .astype('<f4')"
    );
    assert_eq!(
        problem(&npy("<f4", "False", "(6,)", &[0; 24])),
        "it has shape [6]; rays are of shape (N, 6) or (N, 8)"
    );
    assert_eq!(
        problem(&npy("<f4", "True", "(2, 6)", &[0; 48])),
        "it is in Fortran order; save it with numpy.ascontiguousarray"
    );
}

#[test]
fn hostile_headers_are_refused() {
    for shape in [
        "(4294967296, 4294967296, 8)",
        "(99999999999999999999999, 6)",
        // Whose decimal digits alone have a small product.
        "(0xffffffff, 0xffffffff, 8)",
        "(0b1_0000000000_0000000000_0000000000_00, 1_000_000_000, 8)",
        "(0o40000000000, 0o40000000000, 8)",
        // The crate evaluates sums.
        "(2305843009213693952, 1+1+1+1+1+1+1+1)",
    ] {
        let message = problem(&npy("<f4", "False", shape, &[]));
        assert!(message.ends_with("it claims more elements than can be counted"), "{message}");
    }
    assert!(problem(&npy("<f4", "False", &"(".repeat(9_000), &[])).contains("brackets"));
    // Few, but the crate's time is exponential in them: 14 took half a minute.
    assert!(problem(&npy("<f4", "False", &"{".repeat(14), &[])).contains("brackets inside"));
    let hexadecimal = read(&npy("<f4", "False", "(0x2, 6)", &[0; 48])).expect("two rays");
    assert_eq!(hexadecimal.len(), 2);
    let mut long = npy("<f4", "False", "(1, 6)", &[0; 24]);
    long[6] = 2;
    long[8..12].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(problem(&long).contains("longer than 10,000 bytes"));
    for end in 0..40 {
        assert!(read(&npy("<f4", "False", "(1, 6)", &[0; 24])[..end]).is_err());
    }
}
