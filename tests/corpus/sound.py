"""Sound submissions: each must score 100 of 100, with no mistake named."""

from __future__ import annotations

from tests.corpus.sound_figures import FIGURES
from tests.corpus.sound_folders import FOLDERS
from tests.corpus.sound_habits import HABITS
from tests.corpus.sound_habits_more import HABITS_MORE
from tests.corpus.sound_layouts import LAYOUTS, WRAPPED
from tests.corpus.sound_newcomers import NEWCOMERS
from tests.corpus.sound_notebooks import NOTEBOOKS
from tests.corpus.sound_outside import OUTSIDE
from tests.corpus.sound_people import PEOPLE
from tests.corpus.sound_plots import PLOTS
from tests.corpus.sound_styles import STYLES
from tests.corpus.writing import Files

SOUND: dict[str, Files] = {
    **PEOPLE, **STYLES, **FIGURES, **PLOTS, **LAYOUTS, **NOTEBOOKS, **FOLDERS, **HABITS, **HABITS_MORE, **NEWCOMERS, **OUTSIDE,
}  # fmt: skip

__all__ = ["SOUND", "WRAPPED"]
