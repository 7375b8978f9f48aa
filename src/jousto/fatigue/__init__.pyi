# names of jo.fatigue; they are loaded from here when they are first used
from ..materials.strength.factors import (
    finish_factor as finish_factor,
    load_factor as load_factor,
    reliability_factor as reliability_factor,
    roughness_factor as roughness_factor,
    size_factor as size_factor,
)
from ..materials.strength.mean_stress import (
    FKM as FKM,
    SWT as SWT,
    Gerber as Gerber,
    Goodman as Goodman,
    MeanStress as MeanStress,
    Morrow as Morrow,
    PartCompression as PartCompression,
    Soderberg as Soderberg,
    Walker as Walker,
    WeldRatio as WeldRatio,
)
from ..materials.strength.sn_library import estimate_sn as estimate_sn, sn_curves as sn_curves
from ..materials.strength.strain_life import (
    StrainLife as StrainLife,
    strain_life as strain_life,
    strain_lives as strain_lives,
)
from ..materials.strength.welds import fat_class as fat_class, thickness_factor as thickness_factor
from .contact.contact import (
    HertzContact as HertzContact,
    RollingContact as RollingContact,
    hertz_line as hertz_line,
    hertz_point as hertz_point,
    rolling_contact as rolling_contact,
    shakedown_limit as shakedown_limit,
)
from .contact.rolling import (
    RollingLife as RollingLife,
    rolling_life as rolling_life,
    rolling_passes as rolling_passes,
)
from .cycles.duty import DutyCycle as DutyCycle, DutyEvent as DutyEvent
from .cycles.rainflow import (
    Cycles as Cycles,
    RainflowMatrix as RainflowMatrix,
    rainflow as rainflow,
)
from .local.hinge_life import (
    HingeCycles as HingeCycles,
    hinge_cycles as hinge_cycles,
    hinge_life as hinge_life,
)
from .local.strain_life import (
    LocalCycles as LocalCycles,
    LocalPath as LocalPath,
    StrainDamage as StrainDamage,
    glinka as glinka,
    local_cycles as local_cycles,
    local_path as local_path,
    neuber as neuber,
    strain_damage as strain_damage,
)
from .miner.damage import (
    Assessment as Assessment,
    assess as assess,
    damage as damage,
    life as life,
    stress_safety as stress_safety,
)
from .miner.damage_field import DamageField as DamageField, site_cycles as site_cycles
from .multiaxial.counted_planes import PlaneDamage as PlaneDamage, plane_damage as plane_damage
from .multiaxial.planes import (
    CriticalPlane as CriticalPlane,
    DangVan as DangVan,
    FatemiSocie as FatemiSocie,
    Findley as Findley,
    Multiaxial as Multiaxial,
    NormalStress as NormalStress,
    critical_plane as critical_plane,
    multiaxial as multiaxial,
)
from .random.random_response import (
    RandomResponse as RandomResponse,
    SpectralLife as SpectralLife,
    random_response as random_response,
)
from .random.spectral import (
    SpectralDamage as SpectralDamage,
    spectral_damage as spectral_damage,
    spectral_moments as spectral_moments,
    synthesise as synthesise,
)
from .welds.toes import (
    WeldToe as WeldToe,
    hot_spot_stress as hot_spot_stress,
    weld_stress as weld_stress,
)
