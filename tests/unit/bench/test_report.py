"""Text and JSON of reports."""

import json
from datetime import UTC, date, datetime

from bench.report import Report
from bench.sources import digest


def test_further_tables_follow_in_text_and_json(tmp_path):
    below = Report("Seconds", ("planner", "s"), [("astar", 0.25)], ["All cores."])
    report = Report(
        "F", ("planner", "F"), [("astar", 1.5)], ["Means."], {"runs": [1]}, further=[below]
    )
    assert report.text() == (
        "## F\n\n| planner | F   |\n|---------|-----|\n| astar   | 1.5 |\n\nMeans.\n\n"
        "## Seconds\n\n| planner | s    |\n|---------|------|\n| astar   | 0.25 |\n\nAll cores."
    )
    content = json.loads(report.write(tmp_path / "f.json").read_text())
    assert list(content) == ["title", "rows", "notes", "measured", "further", "runs"]
    assert set(content["measured"]) == {"date", "sources", "processor", "cores", "python", "system"}
    assert date.fromisoformat(content["measured"]["date"]) <= datetime.now(UTC).date()
    assert content["measured"]["sources"] == digest("bench", "hdl", "host", "sim")
    assert content["rows"] == [{"planner": "astar", "F": 1.5}]
    assert content["further"] == [
        {"title": "Seconds", "rows": [{"planner": "astar", "s": 0.25}], "notes": ["All cores."]}
    ]
