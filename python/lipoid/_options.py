"""The options of every function but those that read logs, as types.

Made by ``python -m lipoid._write_options`` from the one declaration that the command line and the
docstrings are made from, too: do not edit.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, TypedDict

if TYPE_CHECKING:
    from lipoid._cell import Cell
    from lipoid._log import Log, Logs

Path: TypeAlias = str | os.PathLike[str]


class CampaignOptions(TypedDict, total=False):
    """Keyword arguments."""

    name: str
    capacity_Ah: float | None
    cutoff_V: float | None
    series: int
    parallel: int
    initial_soc: float | None
    constant_current: Logs | None
    low_rate: Logs | None
    low_rate_charge: Logs | None
    pulses: Logs | None
    flight: Logs | None
    validation: Logs | None


class IdentifyDischargeTimesGroup(TypedDict, total=False):
    """Keys of ``discharge_times``."""

    form: Literal["steady", "exact"]
    weighting: Literal["seconds", "relative"]


class IdentifyOpenCircuitVoltageFitGroup(TypedDict, total=False):
    """Keys of ``open_circuit_voltage_fit``."""

    method: Literal["linear", "polynomial", "fourier", "monotone-cubic"]
    knots: int
    interpolate_up_to: int
    degree: int
    harmonics: int
    leave_out_every: int


class IdentifyPulsesGroup(TypedDict, total=False):
    """Keys of ``pulses``."""

    branches: int
    terms: int
    tail: bool
    diffusion: bool
    starts: int


class IdentifySolverGroup(TypedDict, total=False):
    """Keys of ``solver``."""

    function_tolerance: float
    step_tolerance: float
    gradient_tolerance: float
    max_iterations: int


class IdentifyJointGroup(TypedDict, total=False):
    """Keys of ``joint``."""

    branches: int
    most_branches: int
    resistance_nodes: int
    voltage_nodes: int
    self_heating: Literal["auto", "on", "off"]
    charge_transfer: Literal["auto", "on", "off"]
    temperature: Literal["auto", "on", "off"]
    entropy: Literal["auto", "on", "off"]
    hysteresis: Literal["auto", "on", "off"]
    current_offset: Literal["auto", "on", "off"]
    smoothness: float
    charge_uncertainty: float
    voltage_uncertainty_V: float
    iterations_per_variable: int


class IdentifyOptions(TypedDict, total=False):
    """Keyword arguments."""

    method: Literal["staged", "joint"]
    alpha_C: float | None
    open_circuit_voltage: Path | Cell | None
    branches: int | None
    no_diffusion: bool
    fix: Mapping[str, float] | None
    start: Mapping[str, float] | None
    bounds: Mapping[str, tuple[float, float]] | None
    reference: Path | Cell | None
    profile: str | Sequence[str] | None
    discharge_times: IdentifyDischargeTimesGroup
    open_circuit_voltage_fit: IdentifyOpenCircuitVoltageFitGroup
    pulses: IdentifyPulsesGroup
    solver: IdentifySolverGroup
    joint: IdentifyJointGroup


class CompareComparisonGroup(TypedDict, total=False):
    """Keys of ``comparison``."""

    scaling: Literal["none", "typical", "log", "mixed"]
    decades: float
    target: float


class CompareDischargeTimesGroup(TypedDict, total=False):
    """Keys of ``discharge_times``."""

    form: Literal["steady", "exact"]
    weighting: Literal["seconds", "relative"]


class CompareOpenCircuitVoltageFitGroup(TypedDict, total=False):
    """Keys of ``open_circuit_voltage_fit``."""

    method: Literal["linear", "polynomial", "fourier", "monotone-cubic"]
    knots: int
    interpolate_up_to: int
    degree: int
    harmonics: int
    leave_out_every: int


class ComparePulsesGroup(TypedDict, total=False):
    """Keys of ``pulses``."""

    branches: int
    terms: int
    tail: bool
    diffusion: bool
    starts: int


class CompareInteriorPointGroup(TypedDict, total=False):
    """Keys of ``interior_point``."""

    step_tolerance: float
    function_tolerance: float
    iterations_per_variable: int
    hessian: Literal["gauss-newton", "limited-memory"]


class CompareSqpGroup(TypedDict, total=False):
    """Keys of ``sqp``."""

    step_tolerance: float
    function_tolerance: float
    iterations_per_variable: int


class CompareActiveSetGroup(TypedDict, total=False):
    """Keys of ``active_set``."""

    step_tolerance: float
    function_tolerance: float
    iterations_per_variable: int


class CompareLevenbergMarquardtGroup(TypedDict, total=False):
    """Keys of ``levenberg_marquardt``."""

    step_tolerance: float
    function_tolerance: float
    iterations_per_variable: int


class CompareGeneticGroup(TypedDict, total=False):
    """Keys of ``genetic``."""

    step_tolerance: float
    function_tolerance: float
    population: int
    stall: int
    iterations_per_variable: int
    generations: int
    crossover: float
    crossover_index: float
    mutation: float
    mutation_width: float


class CompareParticleSwarmGroup(TypedDict, total=False):
    """Keys of ``particle_swarm``."""

    step_tolerance: float
    function_tolerance: float
    population: int
    stall: int
    iterations_per_variable: int
    constriction: float
    own_attraction: float
    social_attraction: float
    neighbours: int
    maximum_velocity: float


class CompareSimulatedAnnealingGroup(TypedDict, total=False):
    """Keys of ``simulated_annealing``."""

    step_tolerance: float
    function_tolerance: float
    stall: int
    iterations_per_variable: int
    moves: int
    first_temperature: float
    last_temperature: float
    range: float


class CompareCmaEsGroup(TypedDict, total=False):
    """Keys of ``cma_es``."""

    step_tolerance: float
    function_tolerance: float
    population: int
    stall: int
    iterations_per_variable: int
    initial_step: float


class CompareDifferentialEvolutionGroup(TypedDict, total=False):
    """Keys of ``differential_evolution``."""

    step_tolerance: float
    function_tolerance: float
    population: int
    stall: int
    iterations_per_variable: int
    weight: float
    crossover: float


class CompareNelderMeadGroup(TypedDict, total=False):
    """Keys of ``nelder_mead``."""

    step_tolerance: float
    iterations_per_variable: int
    initial_step: float


class CompareBobyqaGroup(TypedDict, total=False):
    """Keys of ``bobyqa``."""

    step_tolerance: float
    iterations_per_variable: int
    initial_step: float


class CompareOptions(TypedDict, total=False):
    """Keyword arguments."""

    optimizers: str | Sequence[str]
    starts: int
    time_constants: bool
    alpha_C: float | None
    open_circuit_voltage: Path | Cell | None
    branches: int | None
    no_diffusion: bool
    fix: Mapping[str, float] | None
    start: Mapping[str, float] | None
    bounds: Mapping[str, tuple[float, float]] | None
    comparison: CompareComparisonGroup
    discharge_times: CompareDischargeTimesGroup
    open_circuit_voltage_fit: CompareOpenCircuitVoltageFitGroup
    pulses: ComparePulsesGroup
    interior_point: CompareInteriorPointGroup
    sqp: CompareSqpGroup
    active_set: CompareActiveSetGroup
    levenberg_marquardt: CompareLevenbergMarquardtGroup
    genetic: CompareGeneticGroup
    particle_swarm: CompareParticleSwarmGroup
    simulated_annealing: CompareSimulatedAnnealingGroup
    cma_es: CompareCmaEsGroup
    differential_evolution: CompareDifferentialEvolutionGroup
    nelder_mead: CompareNelderMeadGroup
    bobyqa: CompareBobyqaGroup


class StudyDischargeTimesGroup(TypedDict, total=False):
    """Keys of ``discharge_times``."""

    form: Literal["steady", "exact"]
    weighting: Literal["seconds", "relative"]


class StudyOpenCircuitVoltageFitGroup(TypedDict, total=False):
    """Keys of ``open_circuit_voltage_fit``."""

    method: Literal["linear", "polynomial", "fourier", "monotone-cubic"]
    knots: int
    interpolate_up_to: int
    degree: int
    harmonics: int
    leave_out_every: int


class StudyPulsesGroup(TypedDict, total=False):
    """Keys of ``pulses``."""

    branches: int
    terms: int
    tail: bool
    diffusion: bool
    starts: int


class StudySolverGroup(TypedDict, total=False):
    """Keys of ``solver``."""

    function_tolerance: float
    step_tolerance: float
    gradient_tolerance: float
    max_iterations: int


class StudyOptions(TypedDict, total=False):
    """Keyword arguments."""

    alpha_C: float | None
    open_circuit_voltage: Path | Cell | None
    branches: int | None
    no_diffusion: bool
    fix: Mapping[str, float] | None
    start: Mapping[str, float] | None
    bounds: Mapping[str, tuple[float, float]] | None
    discharge_times: StudyDischargeTimesGroup
    open_circuit_voltage_fit: StudyOpenCircuitVoltageFitGroup
    pulses: StudyPulsesGroup
    solver: StudySolverGroup


class PlanOptions(TypedDict, total=False):
    """Keyword arguments."""

    pulse_s: float | Sequence[float]
    rest_s: float | Sequence[float]
    rate_C: float | Sequence[float] | None
    sampling_s: float | Sequence[float]
    voltage_noise_V: float
    coloured_noise_V: float | None
    correlation_s: float
    ambient_degC: float | Sequence[float] | None
    second_degC: float | Sequence[float] | None
    temperature_noise_degC: float


class SynthesizeOptions(TypedDict, total=False):
    """Keyword arguments."""

    series: int | None
    parallel: int | None
    rates_C: str | float | Sequence[float]
    low_rate_h: float
    ambient_degC: str | float | Sequence[float]
    pulse_rate_C: float
    pulse_s: float
    rest_s: float
    sampling_s: float
    voltage_noise_V: float
    current_noise_A: float
    voltage_resolution_V: float
    hold: Literal["backward", "forward"]


class FlyWindGroup(TypedDict, total=False):
    """Keys of ``wind``."""

    wind_x_m_per_s: float
    wind_y_m_per_s: float
    wind_z_m_per_s: float
    gusts_m_per_s: float


class FlyControllerGroup(TypedDict, total=False):
    """Keys of ``controller``."""

    law: str
    altitude_omega_rad_per_s: float
    altitude_damping: float
    attitude_omega_rad_per_s: float
    attitude_damping: float
    yaw_omega_rad_per_s: float
    position_omega_rad_per_s: float
    position_speed_m_per_s: float
    climb_m_per_s: float
    descent_m_per_s: float
    saturate: bool
    pwm: Literal["carried", "rounded", "continuous"]
    limit_reference: bool


class FlySimulationGroup(TypedDict, total=False):
    """Keys of ``simulation``."""

    integrator: Literal["rk4", "dormand-prince"]
    substeps: int
    tolerance: float
    motor_lag: bool
    ground: bool
    drag: bool


class FlySensorsGroup(TypedDict, total=False):
    """Keys of ``sensors``."""

    accelerometer_bias: float
    accelerometer_noise: float
    gyro_bias: float
    gyro_noise: float
    sonar_noise_m: float
    pressure_noise_m: float
    pressure_bias_m: float
    flow_noise_m_per_s: float
    voltage_noise_V: float
    voltage_step_V: float


class FlyEstimatorGroup(TypedDict, total=False):
    """Keys of ``estimator``."""

    calibrate: bool
    calibration_samples: int
    accelerometer_weight: float
    gravity_band_m_per_s2: float
    altitude_q_m2_per_s2: float
    altitude_r_m2: float
    sonar_gate_m: float
    pressure_gate_m: float
    reacquire_s: float
    velocity_q_m2_per_s2: float
    velocity_r_m2_per_s2: float


class FlyOptions(TypedDict, total=False):
    """Keyword arguments."""

    vehicle: Path | None
    gains: Path | None
    compensate: bool
    estimate: bool
    xi: float | None
    duration: float | None
    land_below_V: float
    log_step_s: float | None
    waypoints: Path | None
    ambient_degC: float | None
    payload_g: float
    capacity_Ah: float | None
    health: float
    resistance_factor: float
    series: int | None
    parallel: int | None
    initial_soc: float | None
    initial_voltage_V: float | None
    maneuver_options: Mapping[str, Any] | None
    wind: FlyWindGroup
    controller: FlyControllerGroup
    simulation: FlySimulationGroup
    sensors: FlySensorsGroup
    estimator: FlyEstimatorGroup


class EnduranceFlightGroup(TypedDict, total=False):
    """Keys of ``flight``."""

    step_s: float
    longest_s: float


class EnduranceAirGroup(TypedDict, total=False):
    """Keys of ``air``."""

    air_density_kg_per_m3: float
    flat_plate_area_m2: float
    induced_power_factor: float
    profile_power_growth: float
    hover_inflow_share: float


class EnduranceOptions(TypedDict, total=False):
    """Keyword arguments."""

    vehicle: Path | None
    capacity_Ah: float | None
    once: bool
    gains: Path | None
    ensemble: int
    series: int | None
    parallel: int | None
    mission: Literal["hover", "cruise"]
    power: tuple[Any, Any] | None
    airspeed_m_per_s: float | str | tuple[float, float] | None
    ambient_degC: float | str | tuple[float, float] | None
    health: float | str | tuple[float, float] | None
    payload_g: float | str | tuple[float, float] | None
    power_factor: float | str | tuple[float, float] | None
    reserve: float | str | tuple[float, float] | None
    resistance_factor: float | str | tuple[float, float] | None
    cruise_speed: Literal["best-range", "best-endurance"]
    waypoints: Path | None
    initial_soc: float | None
    initial_voltage_V: float | None
    flight: EnduranceFlightGroup
    air: EnduranceAirGroup


class HealthOptions(TypedDict, total=False):
    """Keyword arguments."""

    series: int | None
    parallel: int | None
    capacity_Ah: float | None
    ambient_degC: float | None
    current_scale_uncertainty: float
    columns: Mapping[str, str | int] | None
    units: str | Sequence[str] | None
    current_sign: str
    hold: Literal["backward", "forward"]
    battery: int | None
    most_rows: int | None
    start_s: float
    end_s: float
    lead_resistance_Ohm: float
    steps: int | Sequence[int] | None
    cycles: int | Sequence[int] | None
    voltage_optional: bool


class ExportOptions(TypedDict, total=False):
    """Keyword arguments."""

    mission: Log | Path | None
    series: int | None
    parallel: int | None
    initial_soc: float | None
    initial_voltage_V: float | None
    target_version: str
    branches: int
    precision: Literal["double", "single"]
