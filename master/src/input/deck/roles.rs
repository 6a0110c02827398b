//! Meaning of the fields of cards for included files with offsets of ids, other units or another
//! position (`*INCLUDE_TRANSFORM`): ids by kind, lengths, times and masses, points and vectors.
//!
//! A role is written as `field=role`:
//!
//! | role | meaning |
//! |---|---|
//! | `#n` `#e` `#p` `#s` | id of a node, element, part, set |
//! | `#m` `#f` `#d` `#r` | id of a material, curve (function), definition, or anything else |
//! | `#f:x:y` | id of a curve with the dimensions x of its abscissa and y of its ordinate |
//! | `@x` | first of three coordinates of a point |
//! | `@d` `@v` `@w` | first of three components of a direction, velocity, rotational velocity |
//! | `l` `t` `m` ... | a number of this dimension, see [`dimension`] |
//! | `1` | a number without dimension, or a code |

use std::collections::HashMap;
use std::sync::LazyLock;

/// Kinds of ids, each with its own offset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OffsetKind {
    /// Nodes.
    Node,
    /// Elements.
    Element,
    /// Parts and rigid bodies of nodes.
    Part,
    /// Sets.
    Set,
    /// Materials.
    Material,
    /// Curves and tables.
    Function,
    /// Other definitions: boxes, coordinate systems, vectors.
    Definition,
    /// All others.
    Other,
}

/// Exponents of mass, length and time.
pub type UnitPowers = [i32; 3];

/// Meaning of a field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FieldRole {
    /// An id.
    Id(OffsetKind),
    /// Id of a curve with the dimensions of its abscissa and ordinate.
    Curve(UnitPowers, UnitPowers),
    /// First coordinate of a point.
    Point,
    /// First component of a direction.
    Direction,
    /// First component of a velocity.
    Velocity,
    /// First component of a rotational velocity.
    Spin,
    /// A number with a dimension.
    Number(UnitPowers),
}

/// Returns the exponents of mass, length and time of a dimension by its letter.
fn dimension(letter: &str) -> Option<UnitPowers> {
    Some(match letter {
        "1" => [0, 0, 0],
        "m" => [1, 0, 0],
        "l" => [0, 1, 0],
        "t" => [0, 0, 1],
        "v" => [0, 1, -1],
        "a" => [0, 1, -2],
        "w" => [0, 0, -1],
        // Density, mass per area and per length, moment of inertia.
        "d" => [1, -3, 0],
        "g" => [1, -2, 0],
        "h" => [1, -1, 0],
        "i" => [1, 2, 0],
        // Stress, force, moment.
        "p" => [1, -1, -2],
        "p2" => [2, -2, -4],
        "f" => [1, 1, -2],
        "q" => [1, 2, -2],
        // Stress per length.
        "n" => [1, -2, -2],
        // Force per length and per velocity.
        "k" => [1, 0, -2],
        "c" => [1, 0, -1],
        // Moment per rotational velocity, viscosity.
        "s" => [1, 2, -1],
        "y" => [1, -1, -1],
        // Area, volume, moments of an area.
        "l2" => [0, 2, 0],
        "l3" => [0, 3, 0],
        "l4" => [0, 4, 0],
        // Inverse length, stress, velocity, cube of a stress.
        "1/l" => [0, -1, 0],
        "1/p" => [-1, 1, 2],
        "1/v" => [0, -1, 1],
        "1/p3" => [-3, 3, 6],
        _ => return None,
    })
}

/// Ids with one kind in all keywords.
const IDS: &str = "nid=#n n=#n n1=#n n2=#n n3=#n n4=#n n5=#n n6=#n nid1=#n nid2=#n node1=#n \
    node2=#n nodeid=#n dnid=#n inid=#n m1=#n m2=#n m3=#n pnode=#n eid=#e pid=#p pidl=#p pidc=#p \
    pida=#p pidb=#p lrb=#p sid=#s nsid=#s nsidex=#s psid=#s hsid=#s bsid=#s ssid=#s tsid=#s \
    dsid=#s drcpsid=#s psetid=#s psidex=#s mid=#m tmid=#m lcid=#f tbid=#f curveid=#f lcss=#f \
    lcsr=#f \
    lcd=#f lcr=#f lcdr=#f lcsdg=#f lcregd=#f lcfld=#f lcidph=#f lcidt=#f lcidps=#f dlcidph=#f \
    dlcidt=#f dlcidps=#f lcidx=#f lcidy=#f lcidz=#f dlcidx=#f dlcidy=#f dlcidz=#f lcidab=#f \
    lcbckt=#f lciddr=#f lctm=#f lcdt=#f lcur=#f boxid=#d saboxid=#d sbboxid=#d vid=#d cid=#d \
    icid=#d cida=#d cidb=#d cidl=#d cidd=#d cid_rcf=#d secid=#r hgid=#r eosid=#r wid=#r \
    jid=#r jsid=#r \
    csid=#r id=#r tranid=#d trsid=#d";

/// Roles by keyword, the first entry that fits; a name that ends with `*` fits all that begin with
/// it. Keywords that are listed here can be in files with other units.
const ROLES: &[(&str, &str)] = &[
    ("NODE_TRANSFORM", "trsid=#d nsid=#s immed=1"),
    ("DEFINE_TRANSFORMATION", "tranid=#d a1=1 a2=1 a3=1 a4=1 a5=1 a6=1 a7=1"),
    (
        "INCLUDE_TRANSFORM",
        "idnoff=1 ideoff=1 idpoff=1 idmoff=1 idsoff=1 idfoff=1 iddoff=1 idroff=1 fctmas=1 \
         fcttim=1 fctlen=1 tranid=#d",
    ),
    ("NODE", "x=@x tc=1 rc=1"),
    ("ELEMENT_SHELL", "thic=l beta=1 offset=l"),
    ("ELEMENT_SOLID", ""),
    ("ELEMENT_TSHELL", ""),
    ("ELEMENT_MASS", "mass=m"),
    ("ELEMENT_INERTIA", "ixx=i ixy=i ixz=i iyy=i iyz=i izz=i mass=m"),
    ("ELEMENT_MASS_PART", "addmass=m finmass=m lcid=#f:t:m mwd=1"),
    ("ELEMENT_MASS_NODE_SET", "mass=m"),
    ("ELEMENT_SEATBELT_ACCELEROMETER", "sbacid=#e nid3=#n igrav=1 intopt=1 mass=m"),
    ("ELEMENT_SEATBELT", "sbrid=#e slen=l"),
    ("SECTION_SEATBELT", "area=l2 thick=l"),
    (
        "MAT_SEATBELT",
        "mpul=h llcid=#f:1:f ulcid=#f:1:f lmin=l cse=1 damp=1 e=p a=l2 i=l4 j=l4 as=l2 f=f m=q r=1",
    ),
    (
        "ELEMENT_SEATBELT_SLIPRING",
        "sbsrid=#e sbid1=#e sbid2=#e fc=1 sbrnid=#n ltime=t fcs=1 onid=#n k=1 funcid=#f direct=1 \
         dc=1/v unused=1 lcnffd=#f lcnffs=#f",
    ),
    (
        "ELEMENT_SEATBELT_RETRACTOR",
        "sbrid=#e sbrnid=#n sbid=#e sid1=#e sid2=#e sid3=#e sid4=#e dsid=#e tdel=t pull=l \
         llcid=#f:l:f ulcid=#f:l:f lfed=l lcfl=#f:t:f flopt=1",
    ),
    (
        "ELEMENT_SEATBELT_PRETENSIONER",
        "sbprid=#e sbprty=1 sbsid1=#e sbsid2=#e sbsid3=#e sbsid4=#e sbrid=#e time=t \
         ptlcid=#f:t:l lmtfrc=f",
    ),
    (
        "ELEMENT_SEATBELT_SENSOR",
        "sbsid=#e sbstyp=1 sbsfl=1 dof=1 acc=a atime=t sbrid=#e pulrat=v pultim=t time=t dmx=l \
         dmn=l field=1",
    ),
    ("ELEMENT_BEAM", "rt1=1 rr1=1 rt2=1 rr2=1 local=1 vx=@d pid1=#p pid2=#p"),
    ("ELEMENT_DISCRETE", "s=1 pf=1 offset=l"),
    ("ELEMENT_SPH", "mass=m nend=#n"),
    ("SECTION_SPH", "cslh=1 hmin=1 hmax=1 sphini=l death=t start=t sphkern=1"),
    ("CONTROL_SPH", "idim=1 form=1 dt=t start=t maxv=v ql=1"),
    (
        "CONTROL_ADAPTIVE",
        "adpfreq=t adptol=1 adptyp=1 maxlvl=1 tbirth=t tdeath=t lcadp=1 adpsize=l adpass=1 \
         ireflg=1 adpene=l adpth=l memory=1 orient=1 maxel=1",
    ),
    ("CONTROL_DYNAMIC_RELAXATION", "irelal=1 idrflg=1 drtol=1 drfctr=1 drterm=t tssfdr=1 edttl=1"),
    (
        "PART",
        "grav=1 adpopt=1 xc=@x tm=m ircs=1 vtx=@v vrx=@w ixx=i ixy=i ixz=i iyy=i iyz=i izz=i \
         xl=1 yl=1 zl=1 xlip=1 ylip=1 zlip=1 fs=1 fd=1 dc=1/v vc=p optt=l sft=1 ssf=1 cparm8=1",
    ),
    (
        "PART_COMPOSITE",
        "elform=1 shrf=1 nloc=1 marea=g adpopt=1 thshel=1 fs=1 fd=1 dc=1/v vc=p optt=l sft=1 ssf=1 \
         cparm8=1 mid1=#m thick1=l b1=1 tmid1=1 plyid1=1 shrfac1=1 mid2=#m thick2=l b2=1 tmid2=1",
    ),
    (
        "SECTION_SHELL",
        "elform=1 shrf=1 nip=1 propt=1 qr=1 icomp=1 setyp=1 t1=l t2=l t3=l t4=l nloc=1 marea=g \
         idof=1 edgset=1 angle=1",
    ),
    ("SECTION_TSHELL", "elform=1 shrf=1 nip=1 propt=1 qr=1 icomp=1 tshear=1 angle=1"),
    ("SECTION_SOLID", "elform=1 aet=1 unused=1 cohoff=1 gaskeit=1"),
    (
        "SECTION_BEAM",
        "elform=1 shrf=1 qr=1 cst=1 scoor=1 nsm=h ts1=l ts2=l tt1=l tt2=l nsloc=1 ntloc=1 a=l2 \
         iss=l4 itt=l4 j=l4 sa=l2 ist=l4 field=1 vol=l3 iner=i ca=l2 offset=l rrcon=1 srcon=1 \
         trcon=1",
    ),
    (
        "INTEGRATION_BEAM",
        "irid=#r nip=1 ra=1 icst=1 k=1 d1=l d2=l d3=l d4=l sref=1 tref=1 d5=l d6=l s=1 t=1 wf=1",
    ),
    ("HOURGLASS", "ihq=1 qm=1 ibq=1 q1=1 q2=1 qb=1 qw=1"),
    ("MAT_ELASTIC", "ro=d e=p pr=1 da=1 db=1 k=p"),
    ("MAT_POWER_LAW_PLASTICITY", "ro=d e=p pr=1 k=p n=1 src=w srp=1 sigy=p vp=1 epsf=1"),
    ("MAT_PLASTIC_KINEMATIC", "ro=d e=p pr=1 sigy=p etan=p beta=1 src=w srp=1 fs=1 vp=1"),
    (
        "MAT_PIECEWISE_LINEAR_PLASTICITY",
        "ro=d e=p pr=1 sigy=p etan=p fail=1 tdel=t c=w p=1 lcss=#f:1:p lcsr=#f:w:1 vp=1 eps=1 es=p",
    ),
    (
        "MAT_PLASTICITY_WITH_DAMAGE",
        "ro=d e=p pr=1 sigy=p etan=p eppf=1 tdel=t c=w p=1 lcss=#f:1:p lcsr=#f:w:1 eppfr=1 vp=1 \
         lcdm=#f:1:1 numint=1 eps=1 es=p",
    ),
    (
        "MAT_MODIFIED_PIECEWISE_LINEAR_PLASTICITY",
        "ro=d e=p pr=1 sigy=p etan=p fail=1 tdel=t c=w p=1 lcss=#f:1:p lcsr=#f:w:1 vp=1 epsthin=1 \
         epsmaj=1 numint=1 eps=1 es=p",
    ),
    (
        "MAT_SIMPLIFIED_JOHNSON_COOK",
        "ro=d e=p pr=1 vp=1 a=p b=p n=1 c=1 psfail=1 sigmax=p sigsat=p epso=w",
    ),
    (
        "MAT_TRANSVERSELY_ANISOTROPIC_ELASTIC_PLASTIC",
        "ro=d e=p pr=1 sigy=p etan=p r=1 hlcid=#f:1:p idy=#f:1:1 ea=p coe=1 icfld=#f:1:1 \
         strainlt=1",
    ),
    (
        "MAT_GURSON",
        "ro=d e=p pr=1 sigy=p n=1 q1=1 q2=1 fc=1 f0=1 en=1 sn=1 fn=1 etan=p atyp=1 ff0=1 eps=1 \
         es=p l=l ff=1 lcss=#f:1:p lclf=#f:l:1 numint=1 lcf0=#f:l:1 lcfc=#f:l:1 lcfn=#f:l:1 \
         vgtyp=1",
    ),
    (
        "MAT_ADD_DAMAGE_DIEM",
        "ndiemc=1 dinit=1 deps=1 numfip=1 volfrac=1 dityp=1 p1=#f:1:1 p2=1 p3=1 p4=1 p5=#f:l:1 \
         detyp=1 dctyp=1 q1=l q2=1 q3=1 q4=#f:l:1",
    ),
    ("MAT_SOIL_AND_FOAM", "ro=d g=p bulk=p a0=p2 a1=p a2=1 pc=p vcr=1 ref=1 lcid=#f:1:p eps=1 p=p"),
    (
        "MAT_JOHNSON_HOLMQUIST_CERAMICS",
        "ro=d g=p a=1 b=1 c=1 m=1 n=1 epsi=w t=p sfmax=1 hel=p phel=p beta=1 d1=1 d2=1 k1=p k2=p \
         k3=p fs=1",
    ),
    (
        "MAT_JOHNSON_HOLMQUIST_CONCRETE",
        "ro=d g=p a=1 b=1 c=1 n=1 fc=p t=p eps0=w efmin=1 sfmax=1 pc=p uc=1 pl=p ul=1 d1=1 d2=1 \
         k1=p k2=p k3=p fs=1",
    ),
    (
        "MAT_FABRIC",
        "ro=d ea=p eb=p prba=1 prab=1 gab=p cse=1 el=p prl=1 lratio=1 damp=1 aopt=1 form=1 a1=@d \
         a2=1 a3=1 v1=@d v2=1 v3=1 beta=1",
    ),
    (
        "MAT_ORTHOTROPIC_ELASTIC",
        "ro=d ea=p eb=p ec=p prba=1 prca=1 prcb=1 gab=p gbc=p gca=p aopt=1 g=1 sigf=1 xp=@x a1=@d \
         a2=1 a3=1 macf=1 ihis=1 v1=@d v2=1 v3=1 d1=@d beta=1 ref=1",
    ),
    (
        "MAT_COMPOSITE_DAMAGE",
        "ro=d ea=p eb=p ec=p prba=1 prca=1 prcb=1 gab=p gbc=p gca=p kfail=p aopt=1 macf=1 atrack=1 \
         xp=@x a1=@d a2=1 a3=1 v1=@d v2=1 v3=1 d1=@d beta=1 sc=p xt=p yt=p yc=p alph=1/p3 sn=p \
         syz=p szx=p",
    ),
    (
        "MAT_ENHANCED_COMPOSITE_DAMAGE",
        "ro=d ea=p eb=p ec=p prba=1 prca=1 prcb=1 gab=p gbc=p gca=p kf=1 aopt=1 2way=1 ti=1 xp=@x \
         a1=@d a2=1 a3=1 mangle=1 v1=@d v2=1 v3=1 d1=@d dfailm=1 dfails=1 tfail=1 alph=1/p3 \
         soft=1 fbrt=1 ycfac=1 dfailt=1 \
         dfailc=1 efs=1 xc=p xt=p yc=p yt=p sc=p crit=1 beta=1 pfl=1 epsf=1 epsr=1 tsmd=1 soft2=1 \
         slimt1=1 slimc1=1 slimt2=1 slimc2=1 slims=1 ncyred=1 softg=1 lcxc=#f:w:p lcxt=#f:w:p \
         lcyc=#f:w:p lcyt=#f:w:p lcsc=#f:w:p dt=1",
    ),
    ("EOS_GRUNEISEN", "c=v s1=1 s2=1 s3=1 gamao=1 a=1 e0=p v0=1 lcid=#f:t:1"),
    ("EOS_MURNAGHAN", "gamma=1 k0=p v0=1"),
    (
        "MAT_CONCRETE_DAMAGE_REL3",
        "ro=d pr=1 ft=p a0=p a1=1 a2=1/p b1=1 omega=1 a1f=1 slambda=1 nout=1 edrop=1 rsize=1/l \
         ucf=1/p lcrate=#f:w:1 locwidth=l npts=1 lambda=1 lambda9=1 b3=1 a0y=p a1y=1 eta=1 eta9=1 \
         b2=1 a2f=1/p a2y=1/p",
    ),
    (
        "EOS_TABULATED_COMPACTION",
        "gama=1 e0=p v0=1 lcc=#f:1:p lct=#f:1:1 lck=#f:1:p ev=1 c=p t=1 k=p",
    ),
    ("EOS_TABULATED", "gama=1 e0=p v0=1 lcc=#f:1:p lct=#f:1:1 ev=1 c=p t=1"),
    (
        "MAT_ELASTIC_PLASTIC_HYDRO",
        "ro=d g=p sigy=p eh=p pc=p fs=1 charl=l a1=1 a2=1 spall=1 eps=1 es=p",
    ),
    ("EOS_LINEAR_POLYNOMIAL", "c0=p c1=p c2=p c3=p c4=1 c5=1 c6=1 e0=p v0=1"),
    ("MAT_NULL", "ro=d pc=p mu=y terod=1 cerod=1 ym=p pr=1"),
    (
        "MAT_RIGID",
        "ro=d e=p pr=1 n=1 couple=1 m=1 alias=1 cmo=1 con1=1 con2=1 a1=1 a2=1 a3=1 v1=1 v2=1 v3=1",
    ),
    ("MAT_SPRING_ELASTIC", "k=k"),
    ("MAT_DAMPER_VISCOUS", "dc=c"),
    ("MAT_SPRING_NONLINEAR_ELASTIC", "lcd=#f:l:f lcr=#f:v:1"),
    ("MAT_DAMPER_NONLINEAR_VISCOUS", "lcdr=#f:v:f"),
    ("MAT_SPRING_ELASTOPLASTIC", "k=k kt=k fy=f"),
    ("MAT_SPRING_GENERAL_NONLINEAR", "lcdl=#f:l:f lcdu=#f:l:f beta=1 tyi=f cyi=f"),
    ("MAT_SPRING_MAXWELL", "k0=k ki=k beta=w tc=t fc=f copt=1"),
    ("MAT_SPRING_INELASTIC", "lcfd=#f:l:f ku=k ctf=1"),
    (
        "MAT_LINEAR_ELASTIC_DISCRETE_BEAM",
        "ro=d tkr=k tks=k tkt=k rkr=q rks=q rkt=q tdr=c tds=c tdt=c rdr=s rds=s rdt=s for=f fos=f \
         fot=f mor=q mos=q mot=q",
    ),
    (
        "MAT_NONLINEAR_ELASTIC_DISCRETE_BEAM",
        "ro=d lcidtr=#f:l:f lcidts=#f:l:f lcidtt=#f:l:f lcidrr=#f:1:q lcidrs=#f:1:q lcidrt=#f:1:q \
         lcidtdr=#f:v:f lcidtds=#f:v:f lcidtdt=#f:v:f lcidrdr=#f:w:q lcidrds=#f:w:q \
         lcidrdt=#f:w:q for=f fos=f fot=f mor=q mos=q mot=q ffailr=f ffails=f ffailt=f mfailr=q \
         mfails=q mfailt=q ufailr=l ufails=l ufailt=l tfailr=1 tfails=1 tfailt=1",
    ),
    (
        "MAT_NONLINEAR_PLASTIC_DISCRETE_BEAM",
        "ro=d tkr=k tks=k tkt=k rkr=q rks=q rkt=q tdr=c tds=c tdt=c rdr=s rds=s rdt=s \
         lcpdr=#f:l:f lcpds=#f:l:f lcpdt=#f:l:f lcpmr=#f:1:q lcpms=#f:1:q lcpmt=#f:1:q ffailr=f \
         ffails=f ffailt=f mfailr=q mfails=q mfailt=q ufailr=l ufails=l ufailt=l tfailr=1 tfails=1 \
         tfailt=1 for=f fos=f fot=f mor=q mos=q mot=q",
    ),
    (
        "MAT_GENERAL_NONLINEAR_6DOF_DISCRETE_BEAM",
        "ro=d kt=k kr=q iunld=1 offset=1 dampf=1 iflag=1 lcidtr=#f:l:f lcidts=#f:l:f lcidtt=#f:l:f \
         lcidrr=#f:1:q lcidrs=#f:1:q lcidrt=#f:1:q lcidtur=#f:l:f lcidtus=#f:l:f lcidtut=#f:l:f \
         lcidrur=#f:1:q lcidrus=#f:1:q lcidrut=#f:1:q lcidtdr=#f:v:f lcidtds=#f:v:f lcidtdt=#f:v:f \
         lcidrdr=#f:w:q lcidrds=#f:w:q lcidrdt=#f:w:q lcidter=#f:l:1 lcidtes=#f:l:1 lcidtet=#f:l:1 \
         lcidrer=#f:1:1 lcidres=#f:1:1 lcidret=#f:1:1 utfailr=l utfails=l utfailt=l wtfailr=1 \
         wtfails=1 wtfailt=1 fcrit=1 ucfailr=l ucfails=l ucfailt=l wcfailr=1 wcfails=1 wcfailt=1 \
         iur=l ius=l iut=l iwr=1 iws=1 iwt=1 kts=k ktt=k krs=q krt=q",
    ),
    (
        "MAT_SPOTWELD",
        "ro=d e=p pr=1 sigy=p eh=p dt=t tfail=t efail=1 nrr=f nrs=f nrt=f mrr=q mss=q mtt=q nf=1",
    ),
    (
        "MAT_SPOTWELD_DAMAGE-FAILURE",
        "ro=d e=p pr=1 sigy=p eh=p dt=t tfail=t efail=1 nrr=f nrs=f nrt=f mrr=q mss=q mtt=q nf=1 \
         rs=1 opt=1 fval=1 true_t=l asff=1 beta=1 dmgopt=1",
    ),
    ("DEFINE_HEX_SPOTWELD_ASSEMBLY", "id_sw=#r eid=#e"),
    ("MAT_VISCOELASTIC", "ro=d bulk=p g0=p gi=p beta=w"),
    (
        "MAT_GENERAL_VISCOELASTIC",
        "ro=d bulk=p pcf=1 ef=1 tref=1 a=1 b=1 lcid=#f:t:p nt=1 bstart=w tramp=t lcidk=#f:t:p \
         ntk=1 bstartk=w trampk=t gi=p betai=w ki=p betaki=w",
    ),
    ("MAT_VISCOUS_FOAM", "ro=d e1=p n1=1 v2=y e2=p n2=1 pr=1"),
    (
        "MAT_SAMP-1",
        "ro=d bulk=p gmod=p emod=p nue=1 rbcfac=1 numint=1 lcid_t=#f:1:p lcid_c=#f:1:p \
         lcid_s=#f:1:p lcid_b=#f:1:p nuep=1 lcid_p=#f:1:1 incdam=1 lcid_d=#f:1:1 epfail=1 \
         deprpt=1 lcid_tri=#f:1:1 lcid_lc=#f:l:1 miter=1 mipds=1 incfail=1 iconv=1 asaf=1 nhsv=1 \
         lcemod=#f:w:p beta=w filt=1",
    ),
    ("MAT_BLATZ-KO_RUBBER", "ro=d g=p ref=1"),
    ("MAT_SOFT_TISSUE", "ro=d c1=p c2=p c3=p c4=1 c5=p xk=p s=1"),
    (
        "MAT_SIMPLIFIED_RUBBER/FOAM",
        "ro=d km=p mu=1 g=p sigf=p ref=1 prten=1 sgl=l sw=l st=l lctbid=#f:l:f tension=1 rtype=1 \
         avgopt=t prbeta=1 lcunld=#f:l:f hu=1 shape=1 stol=1 visco=1 hisout=1 gi=p betai=w",
    ),
    ("MAT_CRUSHABLE_FOAM", "ro=d e=p pr=1 lcid=#f:1:p tsc=p damp=1 model=1"),
    (
        "MAT_LOW_DENSITY_FOAM",
        "ro=d e=p lcid=#f:1:p tc=p hu=1 beta=w damp=1 shape=1 fail=1 bvflag=1 ed=p beta1=w kcon=1 \
         ref=1",
    ),
    (
        "MAT_HONEYCOMB",
        "ro=d e=p pr=1 sigy=p vf=1 mu=1 bulk=1 lca=#f:1:p lcb=#f:1:p lcc=#f:1:p lcs=#f:1:p \
         lcab=#f:1:p lcbc=#f:1:p lcca=#f:1:p lcsr=#f:w:1 eaau=p ebbu=p eccu=p gabu=p gbcu=p gcau=p \
         aopt=1 macf=1 xp=@x yp=1 zp=1 a1=@d a2=1 a3=1 d1=@d d2=1 d3=1 tsef=1 ssef=1 v1=@d v2=1 \
         v3=1",
    ),
    (
        "MAT_MODIFIED_HONEYCOMB",
        "ro=d e=p pr=1 sigy=p vf=1 mu=1 bulk=1 lca=#f:1:p lcb=#f:1:p lcc=#f:1:p lcs=#f:1:p \
         lcab=#f:1:p lcbc=#f:1:p lcca=#f:1:p lcsr=#f:w:1 eaau=p ebbu=p eccu=p gabu=p gbcu=p gcau=p \
         aopt=1 macf=1 xp=@x yp=1 zp=1 a1=@d a2=1 a3=1 d1=@d d2=1 d3=1 tsef=1 ssef=1 v1=@d v2=1 \
         v3=1 \
         vref=1 tref=t shdflg=1 lcsra=#f:w:1 lcsrb=#f:w:1 lcsrc=#f:w:1 lcsrab=#f:w:1 \
         lcsrbc=#f:w:1 lcsca=#f:w:1",
    ),
    ("SET_NODE_LIST", "id=#n"),
    ("SET_NODE_LIST_GENERATE", "id=#n"),
    ("SET_NODE_COLUMN", "a=1"),
    ("SET_NODE_ADD", "id=#s"),
    ("SET_NODE_INTERSECT", "id=#s"),
    ("SET_NODE_ADD_ADVANCED", "id=#s type=1"),
    ("SET_NODE_GENERAL", "e=1"),
    ("SET_PART_LIST", "id=#p"),
    ("SET_PART_LIST_GENERATE", "id=#p"),
    ("SET_PART_ADD", "id=#s"),
    ("SET_SEGMENT", "a=1"),
    ("SET_SEGMENT_GENERAL", "e=1"),
    ("SET_SEGMENT_ADD", "id=#s"),
    ("SET_SHELL_ADD", "id=#s"),
    ("SET_SOLID_ADD", "id=#s"),
    ("SET_DISCRETE_ADD", "id=#s"),
    ("SET_BEAM_ADD", "id=#s"),
    ("SET_SHELL_GENERAL", "e=1"),
    ("SET_SOLID_GENERAL", "e=1"),
    ("SET_DISCRETE_GENERAL", "e=1"),
    ("SET_BEAM_GENERAL", "e=1"),
    ("SET_SHELL*", "id=#e"),
    ("SET_SOLID*", "id=#e"),
    ("SET_DISCRETE*", "id=#e"),
    ("SET_BEAM*", "id=#e"),
    ("INITIAL_AXIAL_FORCE_BEAM", "bsid=#s lcid=#f:t:p scale=1 kbend=1"),
    ("DEFINE_CURVE", "sidr=1 sfa=1 sfo=1 offa=1 offo=1 dattyp=1 lcint=1 a=1 o=1"),
    ("DEFINE_BOX", "xmn=1 xmx=1 ymn=1 ymx=1 zmn=1 zmx=1"),
    ("DEFINE_SD_ORIENTATION", "iop=1 xt=@d"),
    ("DEFINE_VECTOR", "xt=@x xh=@x"),
    ("DEFINE_COORDINATE_SYSTEM", "xo=@x xl=@x xp=@x"),
    ("DEFINE_COORDINATE_VECTOR", "xx=@d xv=@d"),
    ("DEFINE_COORDINATE_NODES", "flag=1"),
    ("BOUNDARY_SPC*", "dofx=1 dofy=1 dofz=1 dofrx=1 dofry=1 dofrz=1 birth=t death=t"),
    ("BOUNDARY_NON_REFLECTING", "ad=1 as=1"),
    ("BOUNDARY_PRESCRIBED_MOTION*", "dof=1 vad=1 sf=1 death=t birth=t offset1=l offset2=l"),
    ("INITIAL_VELOCITY_GENERATION", "styp=1 omega=w vx=@v ivatn=1 xc=@x nx=@d phase=1 irigid=1"),
    ("INITIAL_VELOCITY*", "irigid=1 vx=@v vxr=@w vxe=@v vxre=@w"),
    ("LOAD_BODY_PARTS", ""),
    ("LOAD_BODY*", "lcid=#f:t:a drlcid=#f:t:a sf=1 xc=@x ax=1 v1=@d v2=1 v3=1"),
    ("LOAD_GRAVITY_PART*", "dof=1 lc=#f:t:1 accel=a lcdr=#f stga=1 stgr=1"),
    ("LOAD_NODE*", "dof=1 sf=1"),
    ("LOAD_BLAST", "wgt=m xbo=@x tbo=t iunit=1 isurf=1 cfm=1 cfl=1 cft=1 cfp=1 death=t"),
    (
        "LOAD_BLAST_ENHANCED",
        "bid=1 m=m xbo=@x tbo=t unit=1 blast=1 cfm=1 cfl=1 cft=1 cfp=1 nidbo=#n death=t negphs=1 \
         vel=v temp=1 ratio=1 gnid=#n gvid=#d",
    ),
    ("LOAD_BLAST_SEGMENT*", "bid=1 alepid=#p sfnrb=1 scalep=1"),
    ("LOAD_RIGID_BODY", "dof=1 sf=1"),
    ("LOAD_SEGMENT*", "lcid=#f:t:p sf=1 at=t"),
    ("LOAD_SHELL*", "esid=#s lcid=#f:t:p sf=1 at=t"),
    (
        "CONSTRAINED_NODAL_RIGID_BODY",
        "iprt=1 drflag=1 rrflag=1 cmo=1 con1=1 con2=1 xc=@x tm=m ircs=1 vtx=@v vrx=@w ixx=i ixy=i \
         ixz=i iyy=i iyz=i izz=i xl=1 yl=1 zl=1 xlip=1 ylip=1 zlip=1",
    ),
    ("CONSTRAINED_EXTRA_NODES*", ""),
    ("CONSTRAINED_GLOBAL", "tc=1 rc=1 dir=1 x=@x tol=l"),
    ("CONSTRAINED_RIGID_BODIES", "iflag=1"),
    (
        "CONSTRAINED_RIGID_BODY_STOPPERS",
        "lcmax=#f:t:l lcmin=#f:t:l psidmx=#s psidmn=#s lcvmnx=#f:t:v dir=1 tb=t td=t stiff=k",
    ),
    (
        "CONSTRAINED_INTERPOLATION",
        "icid=#r ddof=1 ityp=1 idnsw=1 fgm=1 idof=1 twghtx=1 twghty=1 twghtz=1 rwghtx=1 rwghty=1 \
         rwghtz=1",
    ),
    (
        "CONSTRAINED_BEAM_IN_SOLID",
        "coupid=#r bsid=1 ssid=1 bstyp=1 sstyp=1 ncoup=1 cdir=1 start=t end=t axfor=1 pssf=1 \
         xint=l unused=1",
    ),
    (
        "CONSTRAINED_LAGRANGE_IN_SOLID",
        "coupid=#r lstrsid=1 alesid=1 lstrsty=1 alesty=1 nquad=1 ctype=1 direc=1 mcoup=1 start=t \
         end=t pfac=1 fric=1 frcmin=1 norm=1 normtyp=1 dampfrac=1 k=1 hmin=1 hmax=1 ileak=1 \
         pleak=1 lcidpor=#f nvent=1 iblock=1 iboxid=1 ipenchk=1 intforc=1 ialesof=1 lagmul=1 \
         pfacmm=1 thkf=1 a1=1 b1=1 a2=1 b2=1 a3=1 b3=1 pore=1 unused=1",
    ),
    ("CONSTRAINED_SPOTWELD", "sn=f ss=f n=1 m=1 tf=t ep=1"),
    (
        "CONSTRAINED_GENERALIZED_WELD_SPOT",
        "filter=1 window=1 npr=1 nprt=1 tfail=t epsf=1 sn=f ss=f n=1 m=1",
    ),
    ("CONSTRAINED_NODE_SET", "dof=1 tf=t"),
    ("CONSTRAINED_LINEAR*", "lcid=#r dof=1 coef=1"),
    ("CONSTRAINED_TIED_NODES_FAILURE", "eppf=1 etype=1"),
    ("CONSTRAINED_SHELL_TO_SOLID", ""),
    ("CONSTRAINED_JOINT_STIFFNESS*", ""),
    ("CONSTRAINED_JOINT_SCREW", "rps=1 damp=1 parm=l type=1 r1=1 h_angle=1"),
    ("CONSTRAINED_JOINT*", "rps=1 damp=1"),
    (
        "CONTACT_*",
        "cid=#r surfa=1 surfb=1 surfatyp=1 surfbtyp=1 fs=1 fd=1 dc=1/v vc=p vdc=1 penchk=1 bt=t \
         dt=t sfsa=1 sfsb=1 sast=l sbst=l sfsat=1 sfsbt=1 fsf=1 vsf=1 tiedid=1 region=1 sldthk=l \
         nflf=f sflf=f nen=1 mes=1 nfls=p sfls=p tblcid=#f:l:p thkoff=1 option=1 param=l eraten=k \
         erates=k ct2cn=1 cn=n",
    ),
    (
        "RIGIDWALL_*",
        "offset=l birth=t death=t rwksf=1 xt=@x xh=@x fric=1 wvel=v xhev=@x lenl=l lenm=l mass=m \
         v0=v soft=1 ro=d e=p pr=1 radcyl=l lencyl=l radsph=l lenp=l opt=1 vx=@d",
    ),
    ("DATABASE_CROSS_SECTION_PLANE", "id=1 itype=1 xct=@x xch=@x radius=l xhev=@x lenl=l lenm=l"),
    ("DATABASE_CROSS_SECTION_SET", "id=1 itype=1"),
    ("DATABASE_HISTORY_NODE_SET", "id=#s"),
    ("DATABASE_HISTORY_NODE*", "id=#n"),
    ("DEFORMABLE_TO_RIGID", "ptype=1"),
    (
        "DEFORMABLE_TO_RIGID_AUTOMATIC",
        "swset=1 code=1 time1=t time2=t time3=t entno=1 relsw=1 paired=1 nrbf=1 ncsf=1 rwf=1 \
         dtmax=t d2r=1 r2d=1 offset=1 rpid=#p ptype=1 dpid=#p dptype=1",
    ),
    ("TITLE", ""),
    ("COMMENT", ""),
    ("PARAMETER*", ""),
];

/// Keywords of the list above that have ids and vectors only, or numbers that are not listed.
const NO_UNITS: &[&str] = &["CONSTRAINED_JOINT_STIFFNESS*"];

/// Families with roles of an id, but with numbers without roles.
const IDS_ONLY: &[(&str, &str)] = &[
    ("DEFINE_TABLE*", ""),
    ("SECTION_DISCRETE", ""),
    (
        "AIRBAG_*",
        "sidtyp=1 lct=#f lcmt=#f lcc23=#f lca23=#f lccp23=#f lcap23=#f lcefr=#f lou=#f rbid=1 \
         opt=1 knkdn=1 lcbf=#f rbidp=1",
    ),
    // The dimension of p1 and p2 depends on hr.
    ("MAT_3-PARAMETER_BARLAT", "m=1 a1=@d v1=@d d1=@d"),
    (
        "MAT_GENERAL_SPRING_DISCRETE_BEAM",
        "dof=1 type=1 flcid=#f hlcid=#f glcid=#f mdfail=1 dospot=1",
    ),
    ("MAT_*", "n=1 m=1 n1=1 n2=1 n3=1 idam=1 pvid=1 roflg=1 irate=1 itretrc=1 units=1"),
    ("CONTROL_*", "drcpsid=#s ihq=1 imflag=1 bwc=1 cntco=1 istupd=1 theory=1 endcyc=1 erode=1"),
    ("DAMPING_GLOBAL", ""),
    ("DAMPING_PART_MASS*", "lcid=#f:t:w sf=1 flag=1"),
    ("DAMPING_PART_STIFFNESS*", "coef=1"),
    ("DATABASE_*", "npltc=1 strflg=1 ioopt=1"),
    // The dimension of a critical value is that of its sensor.
    (
        "SENSOR_*",
        "cntlid=#r switid=#r sensid=#r typeid=#r nrep=1 timeoff=1 swit1=#r swit2=#r swit3=#r \
         swit4=#r swit5=#r swit6=#r swit7=#r",
    ),
];

/// Roles of one keyword by field.
#[derive(Debug, Default)]
pub struct KeywordRoles {
    fields: HashMap<&'static str, FieldRole>,
    /// True if the roles of all numbers are known.
    pub has_units: bool,
}

impl KeywordRoles {
    /// Returns the role of a field; `None` for numbers and codes without one.
    pub fn of(&self, field: &str) -> Option<FieldRole> {
        self.fields.get(field).or_else(|| COMMON.get(field)).copied()
    }
}

static COMMON: LazyLock<HashMap<&'static str, FieldRole>> = LazyLock::new(|| parse(IDS));

/// Returns the roles of the fields of a keyword.
pub fn roles_of(keyword: &str) -> KeywordRoles {
    let fits = |pattern: &str| match pattern.strip_suffix('*') {
        Some(start) => keyword.starts_with(start),
        None => keyword == pattern,
    };
    let listed = ROLES.iter().find(|entry| fits(entry.0));
    let has_units = listed.is_some() && !NO_UNITS.iter().any(|pattern| fits(pattern));
    let found = listed.or_else(|| IDS_ONLY.iter().find(|entry| fits(entry.0)));
    let fields = found.map(|(_, roles)| parse(roles)).unwrap_or_default();
    KeywordRoles { fields, has_units }
}

/// Parses roles of fields.
///
/// # Panics
/// Panics if one is invalid: an error in the table, which the tests parse completely.
fn parse(roles: &'static str) -> HashMap<&'static str, FieldRole> {
    let entry = |text: &'static str| {
        let (field, role) = text.split_once('=').expect("field=role");
        (field, one(role).expect("a role"))
    };
    roles.split_whitespace().map(entry).collect()
}

fn one(role: &str) -> Option<FieldRole> {
    let kind = |letter: &str| {
        Some(match letter {
            "n" => OffsetKind::Node,
            "e" => OffsetKind::Element,
            "p" => OffsetKind::Part,
            "s" => OffsetKind::Set,
            "m" => OffsetKind::Material,
            "f" => OffsetKind::Function,
            "d" => OffsetKind::Definition,
            "r" => OffsetKind::Other,
            _ => return None,
        })
    };
    if let Some(id) = role.strip_prefix("#f:") {
        let (x, y) = id.split_once(':')?;
        return Some(FieldRole::Curve(dimension(x)?, dimension(y)?));
    }
    if let Some(id) = role.strip_prefix('#') {
        return kind(id).map(FieldRole::Id);
    }
    match role {
        "@x" => Some(FieldRole::Point),
        "@d" => Some(FieldRole::Direction),
        "@v" => Some(FieldRole::Velocity),
        "@w" => Some(FieldRole::Spin),
        _ => dimension(role).map(FieldRole::Number),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::deck::keywords::FAMILIES;
    use crate::input::deck::table::{Card, Effect, FieldType};

    /// Each role can be read. Each integer of a listed keyword is an id or listed as a code, and
    /// each number of a keyword that may have other units has a dimension, so that no id and no
    /// length of an included file stays as it is.
    #[test]
    fn every_field_of_a_listed_keyword_has_a_role() {
        // Codes by condition, and fields that nothing converts.
        let mut missing = Vec::new();
        let keywords = FAMILIES.iter().flat_map(|family| family.1);
        for keyword in keywords.filter(|k| k.effect == Effect::Model) {
            let roles = roles_of(keyword.name);
            let unused: Vec<&str> =
                keyword.unused.iter().flat_map(|u| u.names.split_whitespace()).collect();
            let cards = keyword.cards.iter().map(|(card, _)| Card::parse(card));
            for field in cards.flat_map(|card| card.fields) {
                // The first component of a vector has the role of all three.
                let is_component = ["y", "z"].iter().any(|c| field.name.contains(c));
                let needs = match field.kind {
                    FieldType::Integer => !roles.fields.is_empty(),
                    FieldType::Real => roles.has_units && !is_component,
                    _ => false,
                };
                let name = field.name.as_str();
                if needs && roles.of(name).is_none() && !unused.contains(&name) {
                    missing.push(format!("*{}: {name}", keyword.name));
                }
            }
        }
        missing.sort();
        missing.dedup();
        assert!(missing.is_empty(), "{missing:#?}");
    }

    /// The first entry that fits decides; common ids apply where it has none.
    #[test]
    fn roles_are_those_of_the_keyword() {
        let of = |keyword: &str, field: &str| roles_of(keyword).of(field);
        assert_eq!(of("MAT_RIGID", "n"), Some(FieldRole::Number([0, 0, 0])));
        assert_eq!(of("LOAD_SEGMENT", "n"), Some(FieldRole::Id(OffsetKind::Node)));
        assert_eq!(of("SET_PART_LIST", "id"), Some(FieldRole::Id(OffsetKind::Part)));
        assert_eq!(of("CONTACT_SPOTWELD", "cid"), Some(FieldRole::Id(OffsetKind::Other)));
        assert_eq!(of("BOUNDARY_SPC_SET", "cid"), Some(FieldRole::Id(OffsetKind::Definition)));
        let stress = FieldRole::Curve([0, 0, 0], [1, -1, -2]);
        assert_eq!(of("MAT_PIECEWISE_LINEAR_PLASTICITY", "lcss"), Some(stress));
        assert!(roles_of("MAT_ELASTIC").has_units && !roles_of("MAT_JOHNSON_COOK").has_units);
    }
}
