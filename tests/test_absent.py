"""What stands for packages that are on other desks: progress and looks cost nothing, and nothing else is pretended."""

from __future__ import annotations

import sys
from collections.abc import Iterator

import pytest

from grader.harness import absent
from tests.corpus.pieces import edit, tidy
from tests.recordings import Marking
from tests.slips import lost_by, marked


@pytest.fixture
def nothing_installed(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    before = dict(sys.modules)
    monkeypatch.setattr(absent.importlib.util, "find_spec", lambda name: None)
    absent.stand_in()
    yield
    for name in [name for name, module in sys.modules.items() if before.get(name) is not module]:
        del sys.modules[name]
    sys.modules.update(before)


@pytest.mark.quick
@pytest.mark.usefixtures("nothing_installed")
def test_a_bar_passes_on_what_it_is_given(capsys: pytest.CaptureFixture[str]) -> None:
    import tqdm
    from tqdm.auto import tqdm as bar
    from tqdm.notebook import trange

    assert list(bar([3, 1, 2], desc="steps", leave=False)) == [3, 1, 2]
    assert [*tqdm.trange(2, 8, 3)] == [*trange(2, 8, 3, unit="step")] == [2, 5]
    assert (len(bar("abc")), len(bar(total=4)), len(bar(iter("abc")))) == (3, 4, 0)
    with tqdm.tqdm(total=2) as steps:
        steps.set_description("on")
        steps.update()
        steps.update(0.5)
        steps.write("done")
    assert steps.n == 1.5
    assert capsys.readouterr().out == "done\n"


@pytest.mark.quick
@pytest.mark.usefixtures("nothing_installed")
def test_looks_are_set_and_nothing_is_drawn() -> None:
    import seaborn as sns

    sns.set_theme(style="whitegrid")
    sns.despine()
    with pytest.raises(ModuleNotFoundError, match="No module named 'seaborn'") as told:
        sns.lineplot(x=[0, 1], y=[0, 1])
    assert told.value.name == "seaborn"
    assert not hasattr(sns, "__wrapped__")


@pytest.mark.quick
def test_what_is_installed_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(absent.importlib.util, "find_spec", lambda name: object())
    before = dict(sys.modules)
    absent.stand_in()
    assert sys.modules == before


def test_a_bar_in_the_recorder_and_a_style_in_the_plot_cost_nothing(player: Marking) -> None:
    steps, figure = "for i in range(n_steps):", "    fig, (top, bottom) = plt.subplots("
    files = edit(
        tidy(),
        "imu_reader.py",
        ("import mujoco\n", "import mujoco\nimport seaborn as sns\nfrom tqdm.auto import tqdm\n"),
        (steps, 'for i in tqdm(range(n_steps), desc="steps"):'),
        (figure, f'    sns.set_style("whitegrid")\n{figure}'),
    )
    assert lost_by(marked(player, files)) == {}


def test_a_plot_of_a_package_that_is_not_here_costs_what_it_draws(player: Marking) -> None:
    drawn = '        top.plot(t, imu_data["acceleration"][:, k], label=f"$a_{axis}$")\n'
    files = edit(
        tidy(),
        "imu_reader.py",
        ("import mujoco\n", "import mujoco\nimport seaborn as sns\n"),
        (drawn, drawn + "        sns.lineplot()\n"),
    )
    result = marked(player, files)
    assert {check.partition(".")[0] for check in lost_by(result)} == {"visualization"}
    assert "No module named 'seaborn'" in str(result)
