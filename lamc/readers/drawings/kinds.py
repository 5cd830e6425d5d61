"""Which bytes begin as XML does: an SVG file, or what is meant as one.

In: bytes. Out: whether. Never: reads them.
"""


def looks_like_xml(data: bytes) -> bool:
    """True for bytes that begin as XML does, in UTF-8 or UTF-16."""
    head = data[:400]
    if head[:2] in (b"\xff\xfe", b"\xfe\xff"):
        head = head[2:].replace(b"\0", b"")
    head = head.removeprefix(b"\xef\xbb\xbf").lstrip()
    return head[:1] == b"<" and (head[1:2].isalpha() or head[1:2] in (b"!", b"?", b"_"))
