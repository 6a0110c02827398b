//! Materials.

use super::title;
use crate::input::deck::record::CardRecord;
use crate::input::deck::table::{
    Keyword,
    Times::{self, *},
    UnusedFields, ignored, no_effect, refused,
};

const SPRING_TITLE: (&str, Times) = ("heading:l", Count(title));

const RATE_OF_STRAIN: UnusedFields =
    ignored("vp", "the yield stress has the factor of the total strain rate, as with vp 0");

const ALL_POINTS: UnusedFields =
    ignored("numint", "an element is removed when all its points have failed");

/// Creates a law of springs or dampers.
const fn spring(
    name: &'static str,
    aliases: &'static [&'static str],
    cards: &'static [(&'static str, Times)],
    note: &'static str,
) -> Keyword {
    Keyword::new(name, cards, note).aliases(aliases).options(&["TITLE"])
}

/// Returns the number of lines of each list of a table without curves: two of five fields.
fn without_curves(record: &CardRecord) -> usize {
    if record.integer("lcc") == 0 { 2 } else { 0 }
}

/// Returns 1, for the line of spall, with the option `SPALL`.
fn spalls(record: &CardRecord) -> usize {
    usize::from(record.has("SPALL"))
}

/// Cards of an axis of MAT_GENERAL_SPRING_DISCRETE_BEAM.
const AXIS_SPRING: (&str, Times) = ("dof:i type:i k:r d:r cdf:r tdf:r", Maybe);
const AXIS_CURVES: (&str, Times) = ("flcid:i hlcid:i c1:r c2:r dle:r glcid:i", Maybe);

pub const KEYWORDS: &[Keyword] = &[
    Keyword::new(
        "MAT_ELASTIC",
        &[("heading:l", Count(title)), ("mid:i! ro:r! e:r! pr:r da:r db:r k:r", Once)],
        "law `elastic`",
    )
    .unused(&[
        ignored("da db", "beams have no damping of their own"),
        no_effect("k", "it is for fluids"),
    ])
    .aliases(&["MAT_001", "MAT_1"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_PLASTIC_KINEMATIC",
        &[
            ("heading:l", Count(title)),
            ("mid:i! ro:r! e:r! pr:r sigy:r! etan:r beta:r", Once),
            ("src:r srp:r fs:r vp:r", Maybe),
        ],
        "law `j2` with the plastic modulus e etan/(e - etan), of which beta is the isotropic share \
         and the rest `kinematic_modulus`. src and srp are `cowper_symonds`, with vp 1 \
         `viscoplastic`; fs is `failure_strain`",
    )
    .aliases(&["MAT_003", "MAT_3"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_PIECEWISE_LINEAR_PLASTICITY",
        &[
            ("heading:l", Count(title)),
            ("mid:i! ro:r! e:r! pr:r sigy:r etan:r fail:r tdel:r", Once),
            ("c:r p:r lcss:i lcsr:i vp:r", Maybe),
            ("eps:r*8", Maybe),
            ("es:r*8", Maybe),
        ],
        "law `j2` with the curve of lcss (`hardening`), with its curves by rate \
         (`hardening_by_rate`), with eps and es, or with sigy and etan; c and p are \
         `cowper_symonds`, lcsr is `rate_factors`, with vp 1 `viscoplastic`; fail is \
         `failure_strain`, tdel is `deletion_step` of its parts of shells and solids",
    )
    .aliases(&["MAT_024", "MAT_24"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_JOHNSON_COOK",
        &[
            ("heading:l", Count(title)),
            ("mid:i! ro:r! g:r e:r pr:r dtf:r vp:r rateop:r", Once),
            ("a:r! b:r n:r c:r m:r tm:r tr:r epso:r", Once),
            ("cp:r pc:r spall:r it:r d1:r d2:r d3:r d4:r", Maybe),
            ("d5:r c2:r erod:r efmin:r numint:r", Maybe),
        ],
        "law `johnson_cook`; the volumetric response is elastic with e and pr (or g), or that of \
         the equation of state of the part (eosid), with pc as `eos_min_pressure` if spall is 1; \
         pc is ignored with a warning without an equation of state, and with other values of \
         spall: tension has no limit then, and no element spalls",
    )
    .unused(&[
        RATE_OF_STRAIN,
        no_effect("it", "plasticity is iterated until it converges"),
        ignored("c2 erod efmin numint", "rates act by c alone; elements fail by d1 to d5 as given"),
    ])
    .aliases(&["MAT_015", "MAT_15"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_PLASTICITY_WITH_DAMAGE",
        &[
            ("heading:l", Count(title)),
            ("mid:i! ro:r! e:r! pr:r sigy:r etan:r eppf:r tdel:r", Once),
            ("c:r p:r lcss:i lcsr:i eppfr:r vp:r lcdm:i numint:r", Maybe),
            ("eps:r*8", Maybe),
            ("es:r*8", Maybe),
        ],
        "law `j2` as for MAT_PIECEWISE_LINEAR_PLASTICITY, with `softening` from eppf to eppfr; a \
         curve of damage (lcdm) is not supported",
    )
    .unused(&[ALL_POINTS])
    .aliases(&["MAT_081", "MAT_81"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_MODIFIED_PIECEWISE_LINEAR_PLASTICITY",
        &[
            ("heading:l", Count(title)),
            ("mid:i! ro:r! e:r! pr:r sigy:r etan:r fail:r tdel:r", Once),
            ("c:r p:r lcss:i lcsr:i vp:r epsthin:r epsmaj:r numint:r", Maybe),
            ("eps:r*8", Maybe),
            ("es:r*8", Maybe),
        ],
        "law `j2` as for MAT_PIECEWISE_LINEAR_PLASTICITY; epsthin is `erosion_thinning`, epsmaj is \
         `erosion_major_strain`",
    )
    .unused(&[ALL_POINTS])
    .aliases(&["MAT_123"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_SIMPLIFIED_JOHNSON_COOK",
        &[
            ("heading:l", Count(title)),
            ("mid:i! ro:r! e:r! pr:r vp:r", Once),
            ("a:r! b:r n:r c:r psfail:r sigmax:r sigsat:r epso:r=1", Once),
        ],
        "law `johnson_cook` without temperature; psfail is D1 of `damage`; sigmax (without vp \
         1), and sigsat without a rate, is `largest_stress`; sigsat with a rate is not supported",
    )
    .unused(&[RATE_OF_STRAIN])
    .aliases(&["MAT_098", "MAT_98"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_POWER_LAW_PLASTICITY",
        &[
            ("heading:l", Count(title)),
            ("mid:i! ro:r! e:r! pr:r k:r! n:r src:r srp:r", Once),
            ("sigy:r vp:r epsf:r", Maybe),
        ],
        "law `j2` with the curve k (e + p)^n (`hardening`), p the plastic strain and e the strain \
         at yield: that of sigy (a strain up to 0.02, else a stress), or without it that at which \
         the curve meets the elastic line. src and srp are `cowper_symonds`, with vp 1 \
         `viscoplastic`; epsf is `failure_strain`",
    )
    .aliases(&["MAT_018", "MAT_18"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_TRANSVERSELY_ANISOTROPIC_ELASTIC_PLASTIC",
        &[
            ("heading:l", Count(title)),
            ("mid:i! ro:r! e:r! pr:r sigy:r etan:r r:r! hlcid:i", Once),
            ("idy:i ea:r coe:r icfld:i unused:r strainlt:r", Maybe),
        ],
        "law `j2` with `lankford` = r, for shells; hlcid is `hardening`",
    )
    .unused(&[
        no_effect("ea coe strainlt", "they are for idy and icfld"),
        no_effect("unused", "it is not used"),
    ])
    .aliases(&["MAT_037", "MAT_37"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_3-PARAMETER_BARLAT",
        &[
            ("heading:l", Count(title)),
            ("mid:i! ro:r! e:r! pr:r! hr:r p1:r p2:r iter:r", Once),
            ("m:r! r00:r! r45:r! r90:r! lcid:i e0:r spi:r p3:r", Once),
            ("aopt:r c:r p:r vlcid:i blank:r pb:r nlp:i htb:i", Maybe),
            ("blank:r blank:r blank:r a1:r a2:r a3:r htc:i htd:i", Maybe),
            ("v1:r v2:r v3:r d1:r d2:r d3:r beta:r htflag:i", Maybe),
            ("usrfail:r lcbi:i lcsh:i", Maybe),
        ],
        "law `barlat`, for shells, with the axes of aopt 0, 2 or 3 and beta: hr 1 is \
         `yield_stress` p2 and the tangent modulus p1, 2 is `swift` with k = p1, n = p2, and e0 or \
         spi, 3 the curve lcid as `hardening`",
    )
    .unused(&[
        ignored("iter", "the return to the yield surface is iterated to round-off"),
        no_effect("blank", "no field of the format"),
        no_effect("p3", "it is for other hr"),
        no_effect("d1 d2 d3", "in a shell the axis a follows from aopt 0, 2 or 3"),
        ignored("htb htc htd htflag", "the state at the start is that of the mesh as given"),
        refused("vlcid pb nlp", "correction of volume, plane strain, forming limits"),
        refused("usrfail lcbi lcsh", "failure of users, curves of biaxial and shear yield"),
    ])
    .aliases(&["MAT_036", "MAT_36"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_GURSON",
        &[
            ("heading:l", Count(title)),
            ("mid:i! ro:r! e:r! pr:r sigy:r n:r q1:r! q2:r!", Once),
            ("fc:r f0:r en:r sn:r fn:r etan:r atyp:r=1 ff0:r", Once),
            ("eps:r*8", Maybe),
            ("es:r*8", Maybe),
            ("l:r*4 ff:r*4", Maybe),
            ("lcss:i lclf:i numint:r=1 lcf0:i lcfc:i lcfn:i vgtyp:r dexp:r", Maybe),
            ("kw:r beta:r m:r", Maybe),
        ],
        "law `gurson`: lcss, or by atyp sigy with the power 1/n, with etan, or eps and es; fn, en, \
         sn are `nucleation`, fc is `critical_void_fraction`; ff0, l with ff, or lclf is the void \
         fraction of failure; vgtyp 1 is `voids_only_grow`, 2 `voids_close`; numint is \
         `failed_points`",
    )
    .unused(&[refused("dexp kw beta m", "damage by shear")])
    .aliases(&["MAT_120"])
    .options(&["TITLE"]),
    Keyword::new(
        "EOS_GRUNEISEN",
        &[
            ("heading:l", Count(title)),
            ("eosid:i! c:r! s1:r s2:r s3:r gamao:r a:r e0:r", Once),
            ("v0:r unused:r lcid:i", Maybe),
        ],
        "`eos_gruneisen` of the MAT_JOHNSON_COOK, MAT_ELASTIC_PLASTIC_HYDRO or MAT_NULL of parts \
         of solids with this eosid; the volume at the start is 1, the energy 0",
    )
    .unused(&[no_effect("unused lcid", "they are for energy that is deposited")])
    .aliases(&["EOS_004", "EOS_4"])
    .options(&["TITLE"]),
    Keyword::new(
        "EOS_LINEAR_POLYNOMIAL",
        &[
            ("heading:l", Count(title)),
            ("eosid:i! c0:r c1:r! c2:r c3:r c4:r c5:r c6:r", Once),
            ("e0:r v0:r", Maybe),
        ],
        "`eos_polynomial` of the materials of parts of solids with this eosid, as EOS_GRUNEISEN; \
         pressure and energy at the start (c0, e0) are 0, the volume is 1",
    )
    .aliases(&["EOS_001", "EOS_1"])
    .options(&["TITLE"]),
    Keyword::new(
        "EOS_TABULATED",
        &[
            ("heading:l", Count(title)),
            ("eosid:i! gama:r e0:r v0:r lcc:i lct:i", Once),
            ("ev:r16*5", Count(without_curves)),
            ("c:r16*5", Count(without_curves)),
            ("t:r16*5", Count(without_curves)),
        ],
        "`eos_table` of the materials of parts of solids with this eosid, as EOS_GRUNEISEN: \
         pressure and temperature over ln V by ev, c and t, or by the curves lcc and lct; the \
         volume at the start is 1, the energy 0",
    )
    .aliases(&["EOS_009", "EOS_9"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_ELASTIC_PLASTIC_HYDRO",
        &[
            ("heading:l", Count(title)),
            ("mid:i! ro:r! g:r! sigy:r eh:r pc:r fs:r charl:r", Once),
            ("a1:r a2:r spall:r", Count(spalls)),
            ("eps:r*8", AtMost(|_| 2)),
            ("es:r*8", AtMost(|_| 2)),
        ],
        "law `j2` of solids with the shear modulus g and the pressure of the equation of state of \
         the part; eps and es, or sigy with the plastic modulus eh; pc is `eos_min_pressure`, fs \
         is `failure_strain`",
    )
    .unused(&[
        refused("a1 a2", "a yield stress that depends on the pressure"),
        refused("charl", "a strain that depends on the size of elements"),
    ])
    .aliases(&["MAT_010", "MAT_10"])
    .options(&["SPALL", "TITLE"]),
    Keyword::new(
        "MAT_RIGID",
        &[
            ("heading:l", Count(title)),
            ("mid:i! ro:r! e:r! pr:r n:r couple:r m:r alias:a", Once),
            ("cmo:r con1:r con2:r", Maybe),
            ("a1:r a2:r a3:r v1:r v2:r v3:r", Maybe),
        ],
        "each of its parts is a `[[rigid]]` body; cmo 1 with con1 and con2 sets `fixed`",
    )
    .unused(&[
        no_effect("couple m alias", "they are for coupling with another program"),
        no_effect("a1 a2 a3 v1 v2 v3", "they are axes of output"),
    ])
    .aliases(&["MAT_020", "MAT_20"])
    .options(&["TITLE"]),
    spring(
        "MAT_SPRING_ELASTIC",
        &["MAT_S01", "MAT_S1"],
        &[SPRING_TITLE, ("mid:i! k:r!", Once)],
        "`spring.stiffness`",
    ),
    spring(
        "MAT_DAMPER_VISCOUS",
        &["MAT_S02", "MAT_S2"],
        &[SPRING_TITLE, ("mid:i! dc:r!", Once)],
        "`spring.damping`",
    ),
    spring(
        "MAT_SPRING_NONLINEAR_ELASTIC",
        &["MAT_S04", "MAT_S4"],
        &[SPRING_TITLE, ("mid:i! lcd:i! lcr:i", Once)],
        "`spring.force_elongation` by lcd; lcr is not supported",
    ),
    spring(
        "MAT_DAMPER_NONLINEAR_VISCOUS",
        &["MAT_S05", "MAT_S5"],
        &[SPRING_TITLE, ("mid:i! lcdr:i!", Once)],
        "`spring.force_rate` by lcdr",
    ),
    spring(
        "MAT_SPRING_ELASTOPLASTIC",
        &["MAT_S03", "MAT_S3"],
        &[SPRING_TITLE, ("mid:i! k:r! kt:r fy:r!", Once)],
        "`spring.elastoplastic` with isotropic hardening",
    ),
    spring(
        "MAT_SPRING_GENERAL_NONLINEAR",
        &["MAT_S06", "MAT_S6"],
        &[SPRING_TITLE, ("mid:i! lcdl:i! lcdu:i! beta:r tyi:r cyi:r", Once)],
        "`spring.hysteresis` with the curves lcdl of loading and lcdu of unloading: beta 0 \
         independent sides, 1 isotropic hardening, for which tyi and cyi are `yield_forces`. Other \
         values of beta (kinematic hardening) are not supported, nor are unloading curves that are \
         less steep than the loading curve at equal forces",
    ),
    spring(
        "MAT_SPRING_MAXWELL",
        &["MAT_S07", "MAT_S7"],
        &[SPRING_TITLE, ("mid:i! k0:r! ki:r beta:r tc:r fc:r copt:r", Once)],
        "`spring.maxwell`: k0 and ki are the stiffness at short and long times, beta is `decay`; \
         with copt the stiffness follows the time (`ageing`); from tc on, if given, the force is \
         fc",
    ),
    spring(
        "MAT_SPRING_INELASTIC",
        &["MAT_S08", "MAT_S8"],
        &[SPRING_TITLE, ("mid:i! lcfd:i! ku:r ctf:r", Once)],
        "`spring.one_sided` with the positive curve lcfd: ctf -1 tension only, 0 and 1 compression \
         only; ku is `unloading_stiffness`",
    ),
    spring(
        "MAT_LINEAR_ELASTIC_DISCRETE_BEAM",
        &["MAT_066", "MAT_66"],
        &[
            SPRING_TITLE,
            ("mid:i! ro:r! tkr:r tks:r tkt:r rkr:r rks:r rkt:r", Once),
            ("tdr:r tds:r tdt:r rdr:r rds:r rdt:r", Maybe),
            ("for:r fos:r fot:r mor:r mos:r mot:r", Maybe),
        ],
        "`discrete_beam.spring` of parts with elform 6: stiffness and damping along and about the \
         axes r, s, t, and preloads",
    ),
    spring(
        "MAT_NONLINEAR_ELASTIC_DISCRETE_BEAM",
        &["MAT_067", "MAT_67"],
        &[
            SPRING_TITLE,
            ("mid:i! ro:r! lcidtr:i lcidts:i lcidtt:i lcidrr:i lcidrs:i lcidrt:i", Once),
            ("lcidtdr:i lcidtds:i lcidtdt:i lcidrdr:i lcidrds:i lcidrdt:i", Maybe),
            ("for:r fos:r fot:r mor:r mos:r mot:r", Maybe),
            ("ffailr:r ffails:r ffailt:r mfailr:r mfails:r mfailt:r", Maybe),
            ("ufailr:r ufails:r ufailt:r tfailr:r tfails:r tfailt:r", Maybe),
        ],
        "the same with curves over displacement, angle and their rates; a curve that begins at the \
         origin acts alike in both directions. Failure by forces (ffailr...) or by displacements \
         (ufailr...): each when the sum of the squares of the ratios to the limits reaches 1",
    ),
    spring(
        "MAT_NONLINEAR_PLASTIC_DISCRETE_BEAM",
        &["MAT_068", "MAT_68"],
        &[
            SPRING_TITLE,
            ("mid:i! ro:r! tkr:r tks:r tkt:r rkr:r rks:r rkt:r", Once),
            ("tdr:r tds:r tdt:r rdr:r rds:r rdt:r", Maybe),
            ("lcpdr:i lcpds:i lcpdt:i lcpmr:i lcpms:i lcpmt:i", Maybe),
            ("ffailr:r ffails:r ffailt:r mfailr:r mfails:r mfailt:r", Maybe),
            ("ufailr:r ufails:r ufailt:r tfailr:r tfails:r tfailt:r", Maybe),
            ("for:r fos:r fot:r mor:r mos:r mot:r", Maybe),
        ],
        "the same with `yielding` on axes with a curve of yield forces over plastic displacement \
         (lcpdr...), which is the sum of that in both directions; a curve without negative \
         displacements acts alike in both. Other axes are linear. Failure as of \
         MAT_NONLINEAR_ELASTIC_DISCRETE_BEAM",
    ),
    spring(
        "MAT_GENERAL_NONLINEAR_6DOF_DISCRETE_BEAM",
        &["MAT_119"],
        &[
            SPRING_TITLE,
            ("mid:i! ro:r! kt:r kr:r iunld:i offset:r dampf:r iflag:i", Once),
            ("lcidtr:i lcidts:i lcidtt:i lcidrr:i lcidrs:i lcidrt:i", Maybe),
            ("lcidtur:i lcidtus:i lcidtut:i lcidrur:i lcidrus:i lcidrut:i", Maybe),
            ("lcidtdr:i lcidtds:i lcidtdt:i lcidrdr:i lcidrds:i lcidrdt:i", Maybe),
            ("lcidter:i lcidtes:i lcidtet:i lcidrer:i lcidres:i lcidret:i", Maybe),
            ("utfailr:r utfails:r utfailt:r wtfailr:r wtfails:r wtfailt:r fcrit:r", Maybe),
            ("ucfailr:r ucfails:r ucfailt:r wcfailr:r wcfails:r wcfailt:r", Maybe),
            ("iur:r ius:r iut:r iwr:r iws:r iwt:r", Maybe),
            ("kts:r ktt:r krs:r krt:r", Maybe),
        ],
        "the same with curves of loading: iunld 0 elastic, 1 `hysteresis` with the curve of \
         unloading, 2 `between_curves` with the stiffness kt or kr, 3 `permanent_set` with the \
         fraction offset. Curves continue beyond their ends. Failure by displacements: fcrit 0 a \
         sum for tension and one for compression, 1 one sum for both",
    )
    .unused(&[
        ignored("dampf", "no damping is added for stability: the step has its limit"),
        refused("iflag", "forces over strains, or of frames that buckle"),
        refused(
            "lcidter lcidtes lcidtet lcidrer lcidres lcidret",
            "damping that depends on the displacement",
        ),
        refused("kts ktt krs krt", "a stiffness of unloading for each axis"),
    ]),
    spring(
        "MAT_GENERAL_SPRING_DISCRETE_BEAM",
        &["MAT_196"],
        &[
            SPRING_TITLE,
            ("mid:i! ro:r! unused1:r unused2:r unused3:r unused4:r mdfail:i dospot:i", Once),
            AXIS_SPRING,
            AXIS_CURVES,
            AXIS_SPRING,
            AXIS_CURVES,
            AXIS_SPRING,
            AXIS_CURVES,
            AXIS_SPRING,
            AXIS_CURVES,
            AXIS_SPRING,
            AXIS_CURVES,
            AXIS_SPRING,
            AXIS_CURVES,
        ],
        "the same with a card for each axis (dof 1 to 6): type 0, with the stiffness k or the \
         curve flcid, as of MAT_NONLINEAR_ELASTIC_DISCRETE_BEAM; type 1: `yielding` with the \
         stiffness k and the curve flcid of yield forces over plastic displacement, as of \
         MAT_NONLINEAR_PLASTIC_DISCRETE_BEAM, or elastic without the curve. The damping is d and \
         the curve hlcid. A beam fails when one axis reaches its limit: tdf, or cdf for negative \
         displacements",
    )
    .unused(&[
        no_effect("unused1 unused2 unused3 unused4", "no field of the format"),
        refused("mdfail", "a rule of failure for several axes"),
        ignored("dospot", "shells that are tied to the beams keep their thickness"),
        refused("c1 c2 glcid", "a stiffness or damping that depends on rate and displacement"),
        no_effect("dle", "it is for c1 and c2"),
    ]),
    Keyword::new(
        "MAT_SPOTWELD",
        &[
            ("heading:l", Count(title)),
            ("mid:i! ro:r! e:r! pr:r sigy:r eh:r dt:r tfail:r", Once),
            ("efail:r nrr:r nrs:r nrt:r mrr:r mss:r mtt:r nf:r", Maybe),
        ],
        "law `j2` with the plastic modulus eh, or `elastic` without sigy; efail is \
         `failure_strain`. For beams, nrr, nrs = nrt, mss = mtt and mrr become `[part.beam.weld]`: \
         normal, shear, bending, torsion. For solids nrr and nrs over the area of a weld become \
         `erosion_weld_normal_stress` and `erosion_weld_shear_stress`. dt (mass scaling) and nf \
         (filter) are not used",
    )
    .aliases(&["MAT_100"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_SPOTWELD_DAMAGE-FAILURE",
        &[
            ("heading:l", Count(title)),
            ("mid:i! ro:r! e:r! pr:r sigy:r eh:r dt:r tfail:r", Once),
            ("efail:r nrr:r nrs:r nrt:r mrr:r mss:r mtt:r nf:r", Maybe),
            ("rs:r opt:r fval:r true_t:r asff:i beta:r unused:r dmgopt:r", Maybe),
        ],
        "as MAT_SPOTWELD with opt 0; with opt 1 nrr (sigax) and nrs (sigsh) are stresses of \
         solids. Damage from efail to rs is `softening`; the solids of an assembly then fail one \
         by one with asff 0, together with 1",
    )
    .unused(&[
        ignored("true_t", "solids of one point have no moment"),
        no_effect("fval", "it is for other opt"),
        no_effect("unused", "no field of the format"),
    ])
    .aliases(&["MAT_100_DAMAGE-FAILURE"])
    .options(&["TITLE"]),
    Keyword::new(
        "DEFINE_HEX_SPOTWELD_ASSEMBLY",
        &[("id_sw:i!", Once), ("eid:i*8", Rest)],
        "`[[failure_group]]`: the solids of a spot weld fail together, and limits of their \
         material that are forces are over their common area",
    )
    .options(&["1", "2", "3", "4", "5", "6", "7", "8", "9", "10", "12", "16"]),
    Keyword::new(
        "MAT_NULL",
        &[("heading:l", Count(title)), ("mid:i! ro:r! pc:r mu:r terod:r cerod:r ym:r pr:r", Once)],
        "parts of shells are `skin`; those of particles are a fluid, see SECTION_SPH: terod \
         and cerod (its erosion) are not supported. Solids have the law `fluid` \
         with an equation of state: mu is `viscosity`, pc `eos_min_pressure`, terod and cerod \
         `erosion_volume_strain` and `erosion_compression`. ym and pr are for contact that needs a \
         stiffness",
    )
    .aliases(&["MAT_009", "MAT_9"])
    .options(&["TITLE"]),
];
