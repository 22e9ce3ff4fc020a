//! Sines and cosines of degrees: the same bits on every target, natively and in the browser.

use hexcast::geometry::Placing;

/// Degrees, and the bits of their sine and cosine.
const TABLE: &[(f64, u64, u64)] = &[
    (1e-9, 0x3db3_30aa_445b_e654, 0x3ff0_0000_0000_0000),
    (0.1, 0x3f5c_9870_1025_eb1f, 0x3fef_fffc_ce4c_8e64),
    (1.0, 0x3f91_df0b_2b89_dd1e, 0x3fef_fec0_97f5_af8a),
    (12.5, 0x3fcb_b44b_13b6_2571, 0x3fef_3dd1_1fb9_74b6),
    (29.999999, 0x3fdf_ffff_efc5_38cc, 0x3feb_b67a_ed07_ae3b),
    (30.0, 0x3fdf_ffff_ffff_ffff, 0x3feb_b67a_e858_4cab),
    (33.3, 0x3fe1_9198_4d01_e95b, 0x3fea_beef_145a_a617),
    (40.0, 0x3fe4_91b7_523c_161c, 0x3fe8_836f_a2cf_5039),
    (44.99999999, 0x3fe6_a09e_666e_4593, 0x3fe6_a09e_6690_3206),
    (45.0, 0x3fe6_a09e_667f_3bcc, 0x3fe6_a09e_667f_3bcd),
    (45.00000001, 0x3fe6_a09e_6690_3206, 0x3fe6_a09e_666e_4593),
    (50.0, 0x3fe8_836f_a2cf_5039, 0x3fe4_91b7_523c_161c),
    (60.0, 0x3feb_b67a_e858_4cab, 0x3fdf_ffff_ffff_ffff),
    (77.7, 0x3fef_43f5_149c_d4eb, 0x3fcb_4494_670d_7988),
    (89.0, 0x3fef_fec0_97f5_af8a, 0x3f91_df0b_2b89_dd1e),
    (90.0, 0x3ff0_0000_0000_0000, 0x0000_0000_0000_0000),
    (100.1, 0x3fef_810c_d019_8aeb, 0xbfc6_726a_b8af_9305),
    (123.456, 0x3fea_b2a9_b25a_9ab9, 0xbfe1_a438_70d3_71f9),
    (180.0, 0x0000_0000_0000_0000, 0xbff0_0000_0000_0000),
    (200.2, 0xbfd6_195d_9e04_3ffd, 0xbfee_0822_8508_d8e6),
    (270.0, 0xbff0_0000_0000_0000, 0x0000_0000_0000_0000),
    (299.9, 0xbfeb_bd9e_4035_fd08, 0x3fdf_e739_1eec_c736),
    (333.33, 0xbfdc_b9fa_40c7_3e2d, 0x3fec_986c_b80c_d670),
    (-17.0, 0xbfd2_b637_cf83_d5c8, 0x3fee_9a0c_6e7b_db1f),
    (-280.0, 0x3fef_838b_8c81_1c17, 0x3fc6_3a1a_7e0b_7389),
    (1000000000.0, 0xbfef_838b_8c81_1c17, 0x3fc6_3a1a_7e0b_7389),
    (720.5, 0x3f81_df37_c495_4c21, 0x3fef_ffb0_2599_c9cd),
    (1e-300, 0x0147_f00f_350a_8ddd, 0x3ff0_0000_0000_0000),
];

/// Holds what a turn about z makes of the unit vector along x to the table.
pub(crate) fn assert_fixed_bits() {
    for &(degrees, sine, cosine) in TABLE {
        let turn = Placing::new([1.0; 3], [0.0, 0.0, degrees], [0.0; 3]).unwrap();
        let found = [turn.matrix()[0][1], turn.matrix()[0][0]].map(f64::to_bits);
        assert_eq!(found, [sine, cosine], "{degrees} degrees: {found:#x?}");
    }
}

#[cfg(not(target_arch = "wasm32"))]
#[test]
fn sines_have_fixed_bits_natively() {
    assert_fixed_bits();
}
