"""Steps, heads and the pipeline: the way of a face as one frozen value."""

from rangeface.pipeline._fingerprint import fingerprint
from rangeface.pipeline._head import Head
from rangeface.pipeline._pipeline import FacePipeline
from rangeface.pipeline._step import Step, step
from rangeface.pipeline._trace import Trace

__all__ = ["FacePipeline", "Head", "Step", "Trace", "fingerprint", "step"]
