"""One file a question; `EXPERIMENTS` lists those that `rangeface experiment NAME` runs."""

from rangeface.evaluation.experiments import (
    best_system,
    denoise_auto,
    denoise_by_recognition,
    denoise_on_captures,
    feature_noise,
    non_faces,
    operating_map,
    passengers,
    population_against_ict,
    registration,
    shipped_model,
    sweeps,
    table1,
    table2,
    table3,
    table4,
    table5,
    table6,
    table7,
    table8,
)
from rangeface.evaluation.experiments._experiment import Experiment

#: Name → experiment, in the order in which `rangeface experiment all` runs them.
EXPERIMENTS: dict[str, Experiment] = {
    "table1": table1.EXPERIMENT,
    "table2": table2.EXPERIMENT,
    "table3": table3.EXPERIMENT,
    "table4": table4.EXPERIMENT,
    "table5": table5.EXPERIMENT,
    "table6": table6.EXPERIMENT,
    "table7": table7.EXPERIMENT,
    "table8": table8.EXPERIMENT,
    "registration": registration.EXPERIMENT,
    "sweeps": sweeps.EXPERIMENT,
    "operating_map": operating_map.EXPERIMENT,
    "best_system": best_system.EXPERIMENT,
    "denoise_by_recognition": denoise_by_recognition.EXPERIMENT,
    "denoise_auto": denoise_auto.EXPERIMENT,
    "denoise_on_captures": denoise_on_captures.EXPERIMENT,
    "feature_noise": feature_noise.EXPERIMENT,
    "population_against_ict": population_against_ict.EXPERIMENT,
    "shipped_model": shipped_model.EXPERIMENT,
    "non_faces": non_faces.EXPERIMENT,
    "passengers": passengers.EXPERIMENT,
}
