"""The whole paper by the command that a user types: all solves, all checks, all figures, and the page of them."""

import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest
from command_line import process
from PIL import Image

from trajopt.results.reproduction.paper_values import EFFORTS, VALUES
from trajopt.results.reproduction.reproduce import EXAMPLES

pytestmark = pytest.mark.usefixtures("folder")


class Page(HTMLParser):
    """The names of the pictures and the addresses of the links of a page."""

    def __init__(self, text: str):
        super().__init__()
        self.pictures, self.links, self.open = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        if tag == "img":
            self.pictures.append(attributes["src"])
        if tag in ("a", "link", "script"):
            self.links.append(attributes.get("href") or attributes.get("src"))
        if tag not in ("img", "meta"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_the_whole_paper(folder):
    run = process("reproduce", "--check", "--json")
    assert all(re.match(r" +\d+ s  (solving|drawing) ", line) for line in run.stderr.splitlines()), "of progress"
    made = json.loads(run.stdout)
    assert [check for check in made["checks"] if not check["passed"]] == []
    assert (run.returncode, made["unsolved"], made["passed"]) == (0, {}, True)
    wanted = {(example, value.name) for example, values in VALUES.items() for value in values}
    assert {(check["example"], check["check"]) for check in made["checks"]} == wanted
    assert [effort["what"] for effort in made["efforts"]] == [effort.what for effort in EFFORTS]
    assert all(effort["here"]["iterations"] < effort["paper"]["iterations"] for effort in made["efforts"])

    text = (folder / "reproduction" / "index.html").read_text()
    page = Page(text)
    assert page.open == []
    files = [picture.file for example in EXAMPLES.values() for picture in example.pictures]
    assert page.pictures == [f"figures/{file}.png" for file in files]
    assert all(link.startswith(("#", "figures/")) for link in page.links)  # no network
    assert "1.114562" in text  # the table of minimum work
    assert "{" not in text.partition("</style>")[2]  # every placeholder of a caption is filled
    for file in files:
        picture = folder / "reproduction" / "figures" / file
        pixels = np.asarray(Image.open(picture.with_suffix(".png")).convert("L"), float)
        assert pixels.std() > 10 and min(pixels.shape) > 300, file
        assert picture.with_suffix(".pdf").read_bytes().startswith(b"%PDF")
    runs = {name for example in EXAMPLES.values() for name in example.runs}
    assert {path.stem for path in (folder / "reproduction" / "results").iterdir()} == runs
