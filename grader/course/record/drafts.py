"""Unsent form entries of the review desk, stored so that a reload or a restart of the desk loses none."""

from __future__ import annotations

from grader.course.record.database import Database

_TABLE = """
CREATE TABLE IF NOT EXISTS drafts (
    author TEXT NOT NULL,
    form TEXT NOT NULL,
    fields TEXT NOT NULL,
    PRIMARY KEY (author, form)
)
"""


class Drafts(Database):
    """Table of the class database for drafts: what each person has typed into forms of the review desk and not sent."""

    def keep_draft(self, author: str, form: str, fields: str) -> None:
        """Store `fields`, JSON of what `author` typed into this form, in place of its last draft; sending calls `drop_draft`."""
        self._write(_TABLE)
        self._write("INSERT OR REPLACE INTO drafts VALUES (?, ?, ?)", author, form, fields)

    def drop_draft(self, author: str, form: str) -> None:
        if self._has_drafts():
            self._write("DELETE FROM drafts WHERE author = ? AND form = ?", author, form)

    def drafts(self, author: str) -> dict[str, str]:
        """Return the unsent fields (as JSON) of `author` by the form's name, to fill the forms again; empty if there are none."""
        if not self._has_drafts():
            return {}
        with self._errors_in_one_line():
            return dict(self._db.execute("SELECT form, fields FROM drafts WHERE author = ? ORDER BY rowid", (author,)))

    def _has_drafts(self) -> bool:
        return self._value("SELECT 1 FROM sqlite_master WHERE name = 'drafts'") is not None
