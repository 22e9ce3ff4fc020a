"""Mesa's Vulkan layer that selects a default device asks Wayland for one, and prints errors where no session runs."""

from __future__ import annotations

import os
import sys


def disable_layer_without_session() -> None:
    """Disables the layer where no session runs, unless the user selects a device by it."""
    has_session = os.path.isabs(os.environ.get("XDG_RUNTIME_DIR", ""))
    selects = any(name in os.environ for name in ("MESA_VK_DEVICE_SELECT", "DRI_PRIME"))
    if sys.platform == "linux" and not has_session and not selects:
        os.environ.setdefault("NODEVICE_SELECT", "1")
