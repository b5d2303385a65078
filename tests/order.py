"""Which process runs which tests: a file stays together, and the files that take longest come first."""

from __future__ import annotations

from xdist.scheduler import LoadFileScheduling

#: Files that take longest, the longest first. Workers begin with them, so that all end at about the same time.
LONGEST = (
    "tracking/test_server_faults.py",
    "test_documented_commands.py",
    "tracking/test_faults.py",
    "report/test_page.py",
    "run/clusters/test_clusters.py",
    "hydra/test_other_plugins.py",
    "test_own_components.py",
    "run/test_kills.py",
    "commands/test_ui.py",
    "commands/test_cli.py",
    "test_new_option.py",
    "commands/test_list.py",
    "benchmarks/test_tracking.py",
    "benchmarks/test_race.py",
    "config/test_every_yaml.py",
    "commands/test_show.py",
    "hydra/test_fast_path.py",
    "commands/test_settings_in_files.py",
    "commands/test_sweep.py",
    "test_documented_configs.py",
    "benchmarks/test_browse.py",
    "commands/test_store.py",
    "commands/test_messages.py",
    "tracking/test_background.py",
    "report/test_multiverse.py",
    "test_compose_file.py",
    "test_components_page.py",
    "benchmarks/test_start.py",
    "learning/test_against_reference.py",
    "commands/test_new.py",
)
_SERVER, _STUDIES = "tests/tracking/test_server_faults.py", "tests/config/test_every_yaml.py"
#: Files that run in the process of another one, because they share its tracking server or its plans of shipped studies,
#: which take seconds.
TOGETHER = {
    "tests/tracking/test_server_writer.py": _SERVER,
    "tests/test_documented_servers.py": _SERVER,
    "tests/report/test_claims_ledger.py": _STUDIES,
    "tests/report/test_curves_figure.py": _STUDIES,
    "tests/report/test_curves_figure_picture.py": _STUDIES,
    "tests/report/test_multiverse.py": _STUDIES,
    "tests/report/test_published_table.py": _STUDIES,
    "tests/tracking/test_views.py": _STUDIES,
}


class Scheduling(LoadFileScheduling):
    """Distribution of files, some of them together."""

    def _split_scope(self, nodeid: str) -> str:
        file = super()._split_scope(nodeid)
        return TOGETHER.get(file, file)
