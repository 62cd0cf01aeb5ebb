"""Damping along the string: each law is a small class that adds to the line's two immittances.

Without damping the shunt admittance per length Y' (N s/rad: torque lost to the surroundings per metre and
speed) is the inertia ρ IP s, and the series admittance times length B' = 1/Z' (N m² s/rad: torque per
speed difference across a metre) the stiffness G IP/s. A law adds to one or both;
γ = √(Y'/B') and Y₀ = √(Y'B') follow (`drillid.physics.line.propagation`). A passive law has
non-negative real parts on the imaginary axis, and every law has X(s*) = X(s)*.

Parameters may be floats, arrays that broadcast against s, or `drillid.physics.dual_numbers.Dual`.
"""

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from drillid.errors import SettingsError
from drillid.physics.dual_numbers import lifted, primal

_LEAST_BORE = 1e-9
"""m; bore diameter that represents a solid section."""


class Steel(Protocol):
    """Properties of a section that a damping law may depend on."""

    @property
    def polar_moment(self) -> Any:
        """IP, m⁴."""

    @property
    def density(self) -> Any:
        """ρ, kg/m³."""

    @property
    def shear_modulus(self) -> Any:
        """G, Pa."""


class DampingLaw:
    """A law without effect; each subclass overrides one or both methods."""

    def shunt(self, section: Steel, s: Any) -> Any:
        """Addition to the shunt admittance per length, N s/rad."""
        return 0.0

    def series(self, section: Steel, s: Any) -> Any:
        """Addition to the series admittance times length, N m² s/rad."""
        return 0.0


@dataclass(frozen=True)
class ViscousWall(DampingLaw):
    """Viscous drag of mud and wall: κ IP (paper, equation 3)."""

    kappa: Any
    """κ, N s/m⁴."""

    def shunt(self, section: Steel, s: Any) -> Any:
        """κ IP, N s/rad."""
        return self.kappa * section.polar_moment


@dataclass(frozen=True)
class KelvinVoigt(DampingLaw):
    """Viscous damping inside the steel, in parallel with its stiffness: δ IP (paper, equation 4)."""

    delta: Any
    """δ, N s/m²."""

    def series(self, section: Steel, s: Any) -> Any:
        """δ IP, N m² s/rad."""
        return self.delta * section.polar_moment


@dataclass(frozen=True)
class HystereticLoss(DampingLaw):
    """Ideal structural damping: G → G (1 + jη sign ω), the same loss per cycle at every frequency.

    Off the imaginary axis sign ω is continued as sign Im s. This is analytic in either half plane, so that
    modes exist, but not across the real axis: the law is not causal (Crandall 1970, Journal of Sound and
    Vibration 11, 3–18) and has no response in time. `ConstantLossFactor` is its causal relative.
    """

    loss_factor: Any
    """η."""

    def series(self, section: Steel, s: Any) -> Any:
        """Loss jη sign(ω) G IP/s, N m² s/rad.

        Raises
        ------
        SettingsError
            For real s, which inverse Laplace transforms require.
        """
        sign = np.sign(np.imag(primal(s)))
        if np.any(sign == 0):
            raise SettingsError(
                "damping law HystereticLoss",
                "it is not causal and has no step or impulse response",
                "Use ConstantLossFactor, which has the same loss factor",
            )
        return 1j * sign * self.loss_factor * section.shear_modulus * section.polar_moment / s


@dataclass(frozen=True)
class ConstantLossFactor(DampingLaw):
    """Causal structural damping: the loss factor η at every frequency, G (1 + jη) at the reference frequency.

    G(s) = G √(1+η²) (s/ω_r)^(2/π · arctan η) (Kjartansson 1979, Journal of Geophysical Research 84,
    4737–4748). It is analytic off the negative real axis, so that step and impulse responses and
    modes are all defined. Causality makes the steel stiffer with frequency: at η = 1 % by 0.64 % for
    each factor e.
    """

    loss_factor: Any
    """η."""
    reference_frequency: Any = 1.0
    """ω_r/2π, Hz, at which the section's shear modulus holds."""

    def series(self, section: Steel, s: Any) -> Any:
        """(G(s) − G) IP/s, N m² s/rad."""
        exponent = 2 / np.pi * np.arctan(self.loss_factor)
        gain = np.sqrt(1 + np.square(self.loss_factor)) * (s / (2 * np.pi * self.reference_frequency)) ** exponent
        return section.shear_modulus * section.polar_moment / s * (gain - 1)


@dataclass(frozen=True)
class RootDrag(DampingLaw):
    """Drag that grows with the root of frequency, b IP √s: the high-frequency limit of `StokesLayerDrag`."""

    coefficient: Any
    """b, N s^(3/2)/m⁴."""

    def shunt(self, section: Steel, s: Any) -> Any:
        """Drag b IP √s, N s/rad."""
        return self.coefficient * section.polar_moment * np.sqrt(s)


@dataclass(frozen=True)
class StokesLayerDrag(DampingLaw):
    """Drag of Newtonian mud on the pipe's outer wall and in its bore (Stokes' second problem on a cylinder).

    The pipe oscillates about its axis and drags along a Stokes layer of mud of thickness √(2μ/ρω), some
    millimetres, thin compared with the annulus. The flow is u = Ωa K₁(λr)/K₁(λa) outside and u = Ωc I₁(λr)/I₁(λc)
    in the bore, with λ = √(ρs/μ), outer radius a and bore radius c. The shear stress μ r d(u/r)/dr at the
    walls gives

        Y' = 2πμa² (2 + λa K₀(λa)/K₁(λa)) + 2πμc² (λc I₀(λc)/I₁(λc) − 2),

    which tends to 2π (a³ + c³) √(ρμs) at high frequency; at low frequency the mud in the bore
    turns as a solid, ρπc⁴s/2.
    Stokes 1851, Transactions of the Cambridge Philosophical Society 9, 8–106; Landau and Lifshitz,
    Fluid Mechanics, § 24.
    """

    density: Any
    """ρ of the mud, kg/m³."""
    viscosity: Any
    """μ of the mud, Pa s."""
    outer_diameter: Any
    """2a, m."""
    inner_diameter: Any = 0.0
    """2c, m; 0 omits the bore."""

    def shunt(self, section: Steel, s: Any) -> Any:
        """Y' of the class docstring, N s/rad."""
        inverse_depth = np.sqrt(self.density * s / self.viscosity)
        outer = self.outer_diameter / 2
        bore = np.maximum(self.inner_diameter, _LEAST_BORE) / 2
        outside = np.square(outer) * (2 + lifted(_outside, _outside_slope, inverse_depth * outer))
        inside = np.square(bore) * (lifted(_inside, _inside_slope, inverse_depth * bore) - 2)
        return 2 * np.pi * self.viscosity * (outside + inside)


def _outside(z: Any) -> Any:
    """Ratio z K₀(z)/K₁(z)."""
    from scipy.special import kve

    return z * kve(0, z) / kve(1, z)


def _outside_slope(z: Any) -> Any:
    ratio = _outside(z) / z
    return 2 * ratio + z * (np.square(ratio) - 1)


def _inside(z: Any) -> Any:
    """Ratio z I₀(z)/I₁(z)."""
    from scipy.special import ive

    return z * ive(0, z) / ive(1, z)


def _inside_slope(z: Any) -> Any:
    ratio = _inside(z) / z
    return 2 * ratio + z * (1 - np.square(ratio))
