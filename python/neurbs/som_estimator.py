"""The interface of a scikit-learn estimator, without scikit-learn."""

from __future__ import annotations

import inspect
import sys
from typing import TYPE_CHECKING, Any

import numpy as np

from neurbs import _core

if TYPE_CHECKING:
    from typing_extensions import Self


def not_fitted(message: str) -> AttributeError:
    """Return the error for an untrained map: scikit-learn's, if it is imported."""
    if "sklearn" in sys.modules:
        from sklearn.exceptions import NotFittedError

        return NotFittedError(message)  # type: ignore[no-any-return]
    return AttributeError(message)


class Estimator:
    """Parameters by name, and the methods that scikit-learn's pipelines and clones call."""

    _map: _core.Map
    stopped_by_: str

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """Return the parameters by name; `deep` has no effect."""
        return {name: getattr(self, name) for name in self._parameters()}

    def set_params(self, **parameters: Any) -> Self:
        """Set parameters by name, and return the map itself."""
        for name, value in parameters.items():
            if name not in self._parameters():
                raise _core.NeurbsError(
                    f"a parameter must be one of {', '.join(self._parameters())}, got {name!r}"
                )
            setattr(self, name, value)
        return self

    def __sklearn_is_fitted__(self) -> bool:
        """Return whether the map is trained, for scikit-learn."""
        return hasattr(self, "_map")

    def __repr__(self) -> str:
        """Return the changed parameters and the state of the training."""
        defaults = {**type(self)().get_params(), "rows": None, "cols": None}
        changed = [
            f"{name}={value!r}"
            for name, value in self.get_params().items()
            if not isinstance(value, np.ndarray) and value != defaults[name]
        ]
        state = [self.stopped_by_] if hasattr(self, "_map") else []
        return f"{type(self).__name__}({', '.join(changed + state)})"

    def __sklearn_tags__(self) -> Any:
        """Return the tags of the estimator, for scikit-learn."""
        from sklearn.utils import InputTags, Tags, TargetTags, TransformerTags

        return Tags(
            estimator_type="clusterer",
            target_tags=TargetTags(required=False),
            transformer_tags=TransformerTags(),
            input_tags=InputTags(),
        )

    @classmethod
    def _parameters(cls) -> list[str]:
        """Names of the constructor's parameters."""
        return list(inspect.signature(cls.__init__).parameters)[1:]
