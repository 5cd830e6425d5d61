"""What moves or bends as one page of HTML: no files beside it, no network. `lamc.export.live` puts models into it."""
