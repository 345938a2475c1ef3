"""A page as its reader finds it: tags, and the texts between them."""

from __future__ import annotations

from html.parser import HTMLParser


class Page(HTMLParser):
    """Every tag with its attributes, and every text with the tag around it; "/p" is an end of what never began."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.texts: list[tuple[str, str]] = []
        self._open = [""]
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(reversed(attrs))))  # of two attributes of one name a browser takes the first
        self._open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag in self._open:
            self._open.remove(tag)
        else:
            self.tags.append((f"/{tag}", {}))

    def handle_data(self, data: str) -> None:
        self.texts.append((self._open[-1], data))

    @property
    def text(self) -> str:
        return "".join(data for _, data in self.texts)

    @property
    def names(self) -> set[str]:
        return {tag for tag, _ in self.tags}
