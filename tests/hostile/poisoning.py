"""Poisoned text: what a submission says wherever the grader may repeat it. It is shown as what it is and does nothing."""

from __future__ import annotations

from tests.corpus.pieces import lab
from tests.corpus.writing import notebook
from tests.hostile.program import FILTER, NOISE, READER, Program, first, in_function, in_method, last, sound

TEXTS = {  # each is put into a source by `ascii`, as a literal that any encoding of the file can hold
    "html": "<script>alert(1)</script><img src=x onerror=alert(1)></pre></td><b>bold</b>",
    "attribute": "\" onmouseover=\"alert(1)\" x=\"' onfocus='alert(1)",
    "template": "{{ 7 * 7 }}{% include 'x' %}${7*7}#{7*7}",
    "ansi": "\x1b[31mred\x1b[2J\x1b]0;title\x07\x9b31m\x08\x08\x08",
    "markup": "[bold red]x[/bold red][link=http://evil.example]y[/link]:boom:",
    "formula": "=HYPERLINK(\"http://evil.example\",\"x\")",
    "formula-by-command": "@SUM(1+1)*cmd|' /C calc'!A0",
    "workflow-command": "x\n::error file=a.py::owned\n::set-output name=score::100\n##[error]x\n::add-mask::x\n::stop-commands::y",
    "xml": "]]></failure></testcase><testcase name=\"x\"/>&xxe;\x00\x0b\ufffe\uffff",
    "right-to-left": "\u202ecod.exe\u202c\u2066x\u2069\u200b\ufeff",
    "line-ends": "a\r\nb\rc\x85d\u2028e\u2029f\x0bg\x0ch",
    "surrogate": "\ud800\udfff\udcff",
    "markdown": "# x\n```\n| a | b |\n[a](javascript:alert(1)) @someone ~~~ <!-- -->",
    "json": '"}, {"score": 100, "x": "\\u0000',
    "tags": "\U000e0041\U000e0042\u00ad\u034f",
    "long": "A" * 100_000,
}


def raises(name: str, text: str) -> Program:
    return Program(f"error-says-{name}", "poison", last(sound(), FILTER, in_method("LowPassFilter", "update", f"raise ValueError({text!a})")), only="filtering")


def names_keys(name: str, text: str) -> Program:
    code = f"return {{{text!a}: np.zeros(3), {text!a} + 'x': 1}}"
    return Program(f"keys-say-{name}", "poison", last(sound(), READER, in_function("simulate_and_collect", code)), only="data_collection")


PLOT = """
def plot_imu_data(imu_data):
    fig, axes = plt.subplots(2, 1)
    for ax, key in zip(axes, ("acceleration", "angular_velocity")):
        for k in range(3):
            ax.plot(imu_data["time"], imu_data[key][:, k], label=@TEXT@)
        ax.set_xlabel(@TEXT@)
        ax.set_ylabel(@TEXT@)
        ax.set_title(@TEXT@)
        ax.legend()
        ax.text(0, 0, @TEXT@)
    fig.suptitle(@TEXT@)
    fig.savefig("imu_data.svg")
"""


def labels(name: str, text: str) -> Program:
    return Program(f"labels-say-{name}", "poison", last(sound(), READER, PLOT.replace("@TEXT@", ascii(text.replace("$", "")))), only="visualization")


SAID = [make(name, text) for make in (raises, names_keys) for name, text in TEXTS.items()]
LABELS = [labels(name, TEXTS[name]) for name in ("html", "ansi", "workflow-command", "right-to-left", "markup", "long")]

# ---------------------------------------------------------------- other places

HTML = TEXTS["html"]
EVERYWHERE = HTML + TEXTS["ansi"] + TEXTS["right-to-left"] + TEXTS["workflow-command"] + TEXTS["formula"]


PLACES = [
    Program("prints", "poison", last(sound(), FILTER, f"import sys\nprint({EVERYWHERE!a}, file=sys.stderr)\nprint({EVERYWHERE!a})\nraise SystemExit({EVERYWHERE!a})"), only="filtering"),
    Program("error-of-a-poisoned-type", "poison", last(sound(), FILTER, in_method("LowPassFilter", "update", f"raise type({EVERYWHERE[:200].replace(chr(0), '')!a}, (Exception,), {{}})({EVERYWHERE!a})")), only="filtering"),
    Program("error-with-poisoned-notes", "poison", last(sound(), FILTER, in_method("LowPassFilter", "update", f"e = KeyError({EVERYWHERE!a})\ne.name = e.filename = {EVERYWHERE!a}\nraise e")), only="filtering"),
    Program("error-in-a-poisoned-line", "poison", last(sound(), FILTER, in_method("LowPassFilter", "update", "raise ValueError  # <script>alert(1)</script> \u202e \x1b[31m ::error::x")), only="filtering"),
    Program("error-of-syntax", "poison", last(sound(), FILTER, "x = = <script>alert(1)</script>"), only="filtering"),
    Program("error-of-import", "poison", last(sound(), FILTER, f"__import__({HTML!a})"), only="filtering"),
    Program("error-in-a-poisoned-file", "poison", last(sound(), FILTER, f"import linecache\nexec(compile('raise ValueError', '<submission>/' + {EVERYWHERE!a}, 'exec'))"), only="filtering"),
    Program("docstrings", "poison", last(sound(), FILTER, f"LowPassFilter.__doc__ = LowPassFilter.__name__ = LowPassFilter.__module__ = LowPassFilter.update.__doc__ = {EVERYWHERE!a}"), only="filtering"),
    Program("returns-a-poisoned-type", "poison", last(sound(), READER, in_function("get_imu_readings", f"return type({EVERYWHERE[:90].replace(chr(0), '')!a}, (), {{}})()")), only="sensor_access"),
    Program("returns-poisoned-text", "poison", last(sound(), READER, in_function("get_imu_readings", f"return {EVERYWHERE!a}, {HTML!a}")), only="sensor_access"),
    Program("noise-of-poisoned-values", "poison", last(sound(), NOISE, in_method("NoisyIMU", "read", f"return {{{EVERYWHERE!a}: {EVERYWHERE!a}}}")), only="noise_model"),
    Program("files-with-poisoned-names", "poison", {**sound(), "<script>alert(1)<.py": "LowPassFilter = 1\n", "\x1b[31mred.py": "x = 1\n", "\u202ecod.py": "x = 1\n", "=cmd.csv": "a", "a\nb.py": "x = 1\n", "::error::x.py": "x = 1\n"}, only="filtering"),
    Program("definitions-in-a-poisoned-file", "poison", {READER: sound()[READER], NOISE: sound()[NOISE], "<b>\u202e\x1b[31m::error::x.py": sound()[FILTER]}, only="filtering"),
    Program("folder-with-a-poisoned-name", "poison", sound(), only="filtering", keeps=("filtering",), folder="<script>alert(1)<\u202e\x1b[31m\n::error::x"),
    Program("student-called-by-a-formula", "poison", sound(), only="filtering", keeps=("filtering",), folder="=HYPERLINK(1)"),
    Program("archive-with-poisoned-names", "poison", {**sound(), "<script>\u202e\x1b[31m.py": "x = 1\n", "../<b>.py": "x", "\\evil\\<i>.py": "y"}, only="filtering", keeps=("filtering",), as_="zip"),
    Program("notebook-with-poisoned-cells", "poison", {"lab.ipynb": notebook("raise ValueError('<script>')", ("markdown", EVERYWHERE.encode("utf-8", "replace").decode()), "<script>alert(1)</script>", "%%writefile <b>.py\nx = 1"), READER: sound()[READER]}, only="filtering"),
]

# ---------------------------------------------------------------- what is hidden, carried out in words

CARRIES = [
    Program(name, "poison", last(files, READER, code), only=criterion, hidden=True)
    for name, files, code, criterion in [
        ("carries-hidden-states-in-an-error", sound(), in_function("get_imu_readings", "raise ValueError('HIDDEN ' + ' '.join(f'{v:.6f}' for v in args[1].qpos))"), "sensor_access"),
        ("carries-hidden-states-in-keys", sound(), in_function("simulate_and_collect", "return {'HIDDEN ' + ' '.join(f'{v:.6f}' for v in args[1].qpos): 1}"), "data_collection"),
        ("carries-hidden-states-in-labels", lab(), in_function("plot_imu_data", "fig, ax = plt.subplots()\nfor _ in range(2):\n    ax.plot(args[0]['time'], args[0]['acceleration'], label='HIDDEN ' + ' '.join(f'{v:.6f}' for v in args[0]['acceleration'][9]))\nax.set_ylabel('HIDDEN ' + ' '.join(f'{v:.6f}' for v in args[0]['acceleration'][9]))\nax.set_title(ax.get_ylabel())\nfig.savefig('imu_data.png')\nreturn"), "visualization"),
        ("carries-hidden-states-in-types", sound(), in_function("get_imu_readings", "return type('HIDDEN_' + '_'.join(f'{v:.6f}' for v in args[1].qpos[:7]), (), {})()"), "sensor_access"),
        ("carries-hidden-states-in-a-type-of-error", sound(), in_function("get_imu_readings", "raise type('HIDDEN_' + '_'.join(f'{v:.6f}' for v in args[1].qpos[:7]), (Exception,), {})('HIDDEN')"), "sensor_access"),
        ("carries-hidden-states-in-a-file-name", sound(), in_function("get_imu_readings", "import linecache\nexec(compile('raise ValueError(1)', '<submission>/HIDDEN ' + str(args[1].qpos[:7]), 'exec'))"), "sensor_access"),
        ("carries-hidden-states-in-a-line-number", sound(), in_function("get_imu_readings", "exec(compile('\\n' * int(1000 * abs(args[1].qpos[0])) + 'raise ValueError(1)', '<submission>/imu_reader.py', 'exec'))"), "sensor_access"),
        ("carries-hidden-states-in-a-missing-module", sound(), in_function("get_imu_readings", "raise ModuleNotFoundError('HIDDEN', name='HIDDEN ' + str(args[1].qpos[:7]))"), "sensor_access"),
        ("carries-hidden-signals-in-values", sound(), in_function("get_imu_readings", "return args[1].qpos[:3] + 4000.0, args[1].qpos[3:6] + 4000.0"), "sensor_access"),
    ]
]
STASHES = last(sound(), READER, in_function("get_imu_readings", "import builtins\nbuiltins.stash = str(args[1].qpos)"))
TELLS = "import builtins\nif hasattr(builtins, 'stash'):\n    raise ImportError('HIDDEN ' + builtins.stash)\nraise ImportError('nothing')"
CARRIES.append(Program("carries-hidden-states-in-a-later-import", "poison", first(STASHES, NOISE, TELLS), hidden=True))
POISONS = [*SAID, *LABELS, *PLACES, *CARRIES]
