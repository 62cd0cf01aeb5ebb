"""Spellings of units against published factors: NIST Special Publication 811, appendix B, and BIPM's SI Brochure."""

import math

import pint
import pytest

from drillid.units import to_si_factor
from drillid.units.names import Unit, known_units

FOOT_POUND, POUND_FORCE, KILOGRAM_FORCE = 1.3558179483314, 4.4482216152605, 9.80665
SHORT_TON_FORCE, LONG_TON_FORCE = 8896.443230521, 9964.01641818352
GALLON, IMPERIAL_GALLON, BARREL, CUBIC_FOOT = 3.785411784e-3, 4.54609e-3, 0.158987294928, 0.028316846592
PSI, ATMOSPHERE, TECHNICAL_ATMOSPHERE = 6894.757293168, 101325.0, 98066.5

TORQUES = {
    1.0: "N.m,N m,Nm,N·m,N*m,N-m,NM,n.m,N⋅m,(N.m),J",
    0.1: "dN.m",
    10.0: "daN.m,daNm,DAN.M,mdaN",
    1e3: "kN.m,kN m,kNm,kN*m,kN·m,kN-m,kN_m,KN.M,KNM,knm,[kN.m],kN . m,кН·м",
    1e4: "kdaN.m,10 kN.m",
    KILOGRAM_FORCE: "kgf.m,kgf-m,kg.m,kg-m,kgm,KGM,mkgf",
    1e3 * KILOGRAM_FORCE: "kkgf.m,t.m,tm,tf.m,тс·м",
    FOOT_POUND: "ft.lbf,ft-lbf,ft lbf,ft·lbf,ft-lbs,ft-lb,ft.lb,ft lbs,FT-LB,FT.LBF,lbf.ft,lbf-ft,lb-ft,lbs-ft,"
    "ftlb,ftlbf,ftlbs,lbft,ft*lbf,ft_lbf,ft x lbf,foot-pounds,pound-feet",
    1e3 * FOOT_POUND: "kft.lbf,kft-lbf,kft-lbs,kft-lb,KFT-LBS,kftlb,kftlbs,kftlbf,klb-ft,klbf.ft,klbf-ft,klbft,KFLB,"
    "1000 ft.lbf,1000 lbf.ft,1000 ft-lbs,x1000 ft-lbs,10^3 ft.lbf,10³ ft·lbf,k ft-lbs,K-FT-LBS,kip-ft,kips.ft",
    FOOT_POUND / 12: "in.lbf,in-lbs,lbf.in,inlb",
    SHORT_TON_FORCE * 0.3048: "tonf[US].ft",
}
SPEEDS = {
    math.pi / 30: "rpm,RPM,Rpm,[rpm],(RPM),r.p.m.,R/PM,rev/min,REV/MIN,rev./min.,rev per minute,r/min,c/min,C/MIN,"
    "cycles/min,turns/min,U/min,tr/min,об/мин,1/min,/min,min-1,min^-1,min⁻¹,1/MIN",
    1e3 * math.pi / 30: "krpm",
    2 * math.pi: "rev/s,c/s,rps,Hz,HZ",
    1e-3: "mrad/s",
    1.0: "rad/s,RAD/S,rad/sec,rad.s-1,rad s⁻¹",
    1 / 60: "rad/min",
    math.pi / 180: "deg/s,dega/s,°/s",
}
FORCES = {
    1e-2: "cN",
    1.0: "N,newton",
    10.0: "daN,DAN,dan",
    1e3: "kN,KN,kn,kilonewtons,кН",
    1e4: "kdaN,KDAN,KDN,10 kN",
    1e6: "MN",
    KILOGRAM_FORCE: "kgf,KGF,kg,KG,kp",
    1e3 * KILOGRAM_FORCE: "kkgf,t,T,tonne,tonnes,TONNES,te,mt,MT,tf,metric ton,metric_tons,1000 kgf,тс,т",
    POUND_FORCE: "lbf,lb,lbs,LBS,pounds,pound-force,lbm",
    1e3 * POUND_FORCE: "klbf,klb,klbs,KLBF,KLB,KLBS,Klbs,k lbs,K-LBS,k-lbf,kip,kips,1000 lbf,1000lbs,1E3 lbf,x1000 lbs,"
    "lbs x 1000,thousand lbs,kpound",
    SHORT_TON_FORCE: "tonf,tonfUS,tonf[US],tonUS,ton[US],short ton",
    LONG_TON_FORCE: "tonfUK,tonf[UK],long_ton",
}
LENGTHS = {
    1.0: "m,M,metre,meters,METERS,mtr",
    1e-2: "cm,CM",
    1e-3: "mm,MM,Mm",
    1e-6: "um,μm",
    0.3048: "ft,FT,Ft,F,feet,foot,'",
    304.8: "kft",
    0.0254: 'in,IN,inch,inches,",″',
    1200 / 3937: "ft[US],ftUS,usft,USFT,USft,sft",
}
PRESSURES = {
    1.0: "Pa,PA,N/m2,N/m²",
    1e3: "kPa,KPA,kpa,kN/m2,кПа",
    1e6: "MPa,MPA,N/mm2,МПа",
    100.0: "hPa,mbar",
    1e4: "dbar",
    133.322387415: "mmHg,mmhg",
    1e5: "bar,BAR,Bar,barg",
    PSI: "psi,PSI,psig,psia,lbf/in2,lb/in2,lbs/in²,lb/sq in",
    1e3 * PSI: "kpsi,ksi",
    TECHNICAL_ATMOSPHERE: "kgf/cm2,kg/cm2,kgf/cm²,kg/cm^2,ksc,at",
    ATMOSPHERE: "atm",
}
FLOWS = {
    1.0: "m3/s,m³/s,m^3/s,m**3/s",
    1 / 60: "m3/min,M3/MIN,m³/min,cu m/min",
    1 / 3600: "m3/h,m³/h,m3/hr,M3/HR,cum/h,m3.h-1",
    1 / 86400: "m3/d",
    1e-3 / 60: "L/min,l/min,LPM,lpm,L/PM,LIT/MIN,ltr/min,litre/min,liters/min,dm3/min,L min⁻¹",
    1e-3: "L/s,l/sec,dm3/s,л/с",
    GALLON / 60: "gpm,GPM,USGPM,gal/min,GAL/MIN,galUS/min,gal[US]/min,gal(US)/min,US gal/min,USgal/min,gallons/min,"
    "g/pm",
    IMPERIAL_GALLON / 60: "galUK/min,gal[UK]/min,UK gal/min,igpm,imp gal/min",
    BARREL / 60: "bbl/min,bpm,BPM",
    BARREL / 86400: "bbl/d",
    CUBIC_FOOT / 60: "ft3/min,cu ft/min,cfm",
}
DATA_SHEETS = {
    ("kg m^2", 1.0): "kg.m2,kg m²,kg*m^2,kgm2,kgm²,KGM2",
    ("kg m^2", 0.04214011009380): "lbm.ft2,lb-ft²,lb ft^2,lbft2",
    ("kg m^2", 1.3558179483314): "slug ft2,lbf.ft.s2",
    ("N m s/rad", 1.0): "N m s/rad,Nms/rad,N.m.s/rad,N m/(rad/s),Nms",
    ("N m s/rad", 3e4 / math.pi): "kNm/rpm,kN.m/(rev/min)",
    ("N m/rad", 1e3): "kNm/rad,kN·m/rad",
    ("kg/m^3", 1e3): "g/cm3,g/cc,SG,sg,kg/L,t/m3",
    ("kg/m^3", 119.826427316897): "ppg,lb/gal,lbm/gal[US],PPG",
    ("dimensionless", 0.01): "%,pct,percent",
    ("Hz", 1.0): "Hz,1/s,s-1,samples/s,sps",
    ("Hz", 1e3): "kHz,khz,KHZ,kilohertz",
    ("Hz", 1e-3): "mHz",
    ("Hz", 1e6): "MHz",
    ("s", 1e-3): "ms,MS,msec",
    ("s", 1e-6): "us,μs,µs,microseconds",
    ("s", 1e-9): "ns",
    ("Pa", 1e9): "GPa,GPA,kN/mm2",
}
KINDS = {"N m": TORQUES, "rad/s": SPEEDS, "N": FORCES, "m": LENGTHS, "Pa": PRESSURES, "m^3/s": FLOWS}
SPELLINGS = [
    (spelling, si_unit, factor)
    for si_unit, kind in KINDS.items()
    for factor, spellings in kind.items()
    for spelling in spellings.split(",")
] + [(spelling, si_unit, factor) for (si_unit, factor), text in DATA_SHEETS.items() for spelling in text.split(",")]


@pytest.mark.parametrize(("spelling", "si_unit", "factor"), SPELLINGS)
def test_a_spelling_has_its_published_factor(spelling: str, si_unit: str, factor: float) -> None:
    assert to_si_factor(spelling, si_unit) == pytest.approx(factor, rel=1e-12)
    assert to_si_factor(f" {spelling} ", si_unit) == pytest.approx(factor, rel=1e-12)


OTHERWISE_IN_PINT = {
    *("Nm", "kNm", "daNm", "MNm", "Nms", "kNms", "ftlb", "ftlbs", "mkgf", "F", "T", "mt", "mT", "MT", "mton", "kilos"),
    *("bbl", "bbls", "barrel", "barrels", "cfm", "pct", "k", "K", "c", "U", "rads", "usft"),
}


def test_names_that_mean_something_else_in_general_physics_are_these() -> None:
    differing = {name for name, unit in known_units().items() if not _as_in_pint(name, unit)}
    assert differing == OTHERWISE_IN_PINT


def _as_in_pint(name: str, unit: Unit) -> bool:
    """Whether pint does not know the name, or has the same unit for it."""
    try:
        quantity = pint.application_registry.Quantity(1.0, name).to_base_units()
    except (pint.errors.PintError, AssertionError, TypeError, AttributeError):
        return True
    powers = dict(quantity.dimensionality)
    dimension = tuple(powers.pop(f"[{base}]", 0) for base in ("length", "mass", "time"))
    return not powers and dimension == unit.dimension and math.isclose(quantity.magnitude, unit.factor, rel_tol=1e-7)
