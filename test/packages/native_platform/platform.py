from platformio.public import PlatformBase


class NativePlatform(PlatformBase):
    """The compilers of this computer: nothing to install."""
