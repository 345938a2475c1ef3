"""Sound submissions that lie in more than one folder: a program above `src`, shared settings, a folder for each step."""



from __future__ import annotations

from tests.corpus.pieces import HEAD, MODEL_PATH, edit, tidy
from tests.corpus.writing import Content, notebook

Files = dict[str, Content]

_SETTING = f'MODEL_PATH = "{MODEL_PATH}"\n'
_PARTNERS = "from imu_reader import MODEL_PATH\nfrom noisy_imu import NoisyIMU\n"
_FILTER, _, _REST = tidy()["filters.py"].partition("def compare")
FILTER = _FILTER.replace(_PARTNERS, "")
COMPARISON = f"def compare{_REST}"


def three(settings: str, partner: str = "from imu_reader import get_imu_readings") -> dict[str, str]:
    """The three files; the reader finds the model by `settings`, the noise model its reader by `partner`, and none compares."""
    files = edit(tidy(), "imu_reader.py", (_SETTING, settings))
    files = edit(files, "noisy_imu.py", ("from imu_reader import MODEL_PATH, get_imu_readings", partner))
    return {**files, "filters.py": FILTER}


def below(folder: str, files: dict[str, str]) -> dict[str, str]:
    return {f"{folder}/{name}": content for name, content in files.items()}


def program(imports: str) -> str:
    return f"{HEAD}\n{imports}\n\n{COMPARISON}"


FOLDERS: dict[str, Files] = {
    "main_and_settings_above_src": {
        "main.py": program("from config import MODEL_PATH\nfrom src.filters import LowPassFilter\nfrom src.noisy_imu import NoisyIMU"),
        "config.py": _SETTING,
        "src/__init__.py": "",
        **below("src", three("from config import MODEL_PATH\n", "from src.imu_reader import get_imu_readings")),
    },
    "relative_imports_from_above": {
        "lab/__init__.py": "",
        "lab/__main__.py": program("from .config import MODEL_PATH\nfrom .imu.filters import LowPassFilter\nfrom .imu.noisy_imu import NoisyIMU"),
        "lab/config.py": _SETTING,
        "lab/imu/__init__.py": "",
        **below("lab/imu", three("from ..config import MODEL_PATH\n", "from .imu_reader import get_imu_readings")),
    },
    "a_folder_for_each_step": {
        "common/__init__.py": _SETTING,
        "step2/imu_reader.py": three(
            "import os\nimport sys\n\nsys.path.append(os.path.join(os.path.dirname(__file__), '..'))\nfrom common import MODEL_PATH\n"
        )["imu_reader.py"],
        "step5/noisy_imu.py": three("", "import sys\n\nsys.path.insert(0, '../step2')\nfrom imu_reader import get_imu_readings")["noisy_imu.py"],
        "step6/filters.py": edit(tidy(), "filters.py", (_PARTNERS, "import sys\n\nsys.path += ['../step2', '../step5']\n" + _PARTNERS))["filters.py"],
    },
    "notebook_above_src_compares": {
        "lab.ipynb": notebook(f"{HEAD}\nimport sys\n\nsys.path.append('src')\n{_PARTNERS}from filters import LowPassFilter", COMPARISON),
        **below("src", three(_SETTING)),
    },
    "settings_in_a_folder_beside": {
        "config/settings.json": f'{{"model": "{MODEL_PATH}"}}',
        "scripts/run_all.py": program(
            "import sys\nfrom pathlib import Path\n\nsys.path.insert(0, str(Path(__file__).resolve().parent.parent / 'src'))\n"
            + _PARTNERS + "from filters import LowPassFilter"
        ),
        **below("src", three(
            "import json\nfrom pathlib import Path\n\nSETTINGS = Path(__file__).parent.parent / 'config' / 'settings.json'\n"
            "MODEL_PATH = json.loads(SETTINGS.read_text())['model']\n"
        )),
    },
}
