"""Pages to be printed, as Jinja2 templates of `app/templates`, in the language in use.

    {{ tr("Module") }}       a text of the program, translated
    {{ name }}               any other value is plain text: on one line, bounded, escaped
    {{ finding | say }}      a message that was kept as JSON, translated

A template has only what Qt's rich text knows: tables, colours and sizes.
"""

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from app.text.i18n import tr
from app.text.messages import clean, message_from_json

if TYPE_CHECKING:  # imported on first use, to keep the start fast
    from jinja2 import Environment

TEMPLATES: Final = Path(__file__).parents[1] / "templates"
LONGEST: Final = 320  # characters of one value; the whole text is in the record


def page(template: str, /, **values: Any) -> str:
    """The HTML of a page or of a part of one."""
    return _environment().get_template(template).render(**values)


@cache
def _environment() -> "Environment":
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup

    environment = Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        # What people typed, or that came out of a file, does no harm where it is printed. Markup is our own.
        finalize=lambda value: value if isinstance(value, Markup) else clean(str(value), longest=LONGEST),
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals["tr"] = tr
    environment.filters["say"] = lambda kept: message_from_json(kept).translated()
    environment.filters["cut"] = lambda text, longest: clean(str(text), longest=longest)
    return environment
