"""What the names of exported C may begin with: what neither C's libraries nor the systems that C lives on have taken.

In: a design's name, or a prefix that somebody asks for. Out: a prefix, or an ExportError. An export of prefix p has
files p.h and p.c, a type p_t, functions p_step and the like, macros P_OK and the like; each could meet another's.
"""

import re

from lamc.basics.checks import shown
from lamc.basics.errors import ExportError
from lamc.codegen.names import MAX_IDENTIFIER, RESERVED, identifier

# p.h would be found in the place of the header that a program means.
_HEADERS = """
    assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdalign stdarg stdatomic
    stdbit stdbool stdckdint stddef stdint stdio stdlib stdnoreturn string tgmath threads time uchar wchar wctype
    alloca dirent dlfcn fcntl fmtmsg fnmatch ftw getopt glob grp iconv inet io langinfo libgen malloc memory monetary
    ndbm netdb nl_types poll process pthread pwd regex sched search semaphore spawn strings strops syslog tar termios
    types ucontext ulimit unistd utime utmpx varargs windows winsock wordexp
"""
# p_t is a type of C or POSIX.
_TYPES = """
    blkcnt blksize caddr char8 char16 char32 clock clockid cnd daddr dev div error fexcept fpos fsblkcnt
    fsfilcnt fsid gid greg id idtype ino int8 int16 int32 int64 int_fast8 int_fast16 int_fast32 int_fast64 int_least8
    int_least16 int_least32 int_least64 intmax intptr key ldiv lldiv imaxdiv locale loff max_align mbstate mcontext
    mode mtx nl_catd nlink nullptr off off64 pid ptrdiff quad regmatch regoff rlim rsize sa_family sig_atomic siginfo
    sigset size socklen ssize stack suseconds thrd timer tss uid uint uint8 uint16 uint32 uint64 uint_fast8
    uint_fast16 uint_fast32 uint_fast64 uint_least8 uint_least16 uint_least32 uint_least64 uintmax uintptr useconds
    wctrans wint
"""
# Macros of POSIX (R_OK) and of compilers for some machines, names that Windows does not allow, the example's file.
_OTHERS = """
    f r w x i386 arm mips sparc sun hpux vms vax m68k con prn aux nul com1 com2 com3 com4 lpt1 lpt2 lpt3 example_main
"""
TAKEN = RESERVED | set((_HEADERS + _TYPES + _OTHERS).split())

_PREFIX = re.compile(r"[A-Za-z](?:_?[A-Za-z0-9])*")


def prefix_of(name: str) -> str:
    """A prefix that resembles the name of a design."""
    return identifier(name, taken=TAKEN)


def check_prefix(prefix: object) -> None:
    """Raises ExportError for what is no prefix."""
    rule = f"letters, digits and single _, a letter first, {MAX_IDENTIFIER} characters at most"
    if not isinstance(prefix, str) or not _PREFIX.fullmatch(prefix) or len(prefix) > MAX_IDENTIFIER:
        raise ExportError(f"--prefix (prefix) is {shown(prefix)}; it must be a C name: {rule}")
    if prefix.lower() in TAKEN:
        raise ExportError(
            f"--prefix (prefix) is {prefix!r}, which C, C++, a system or lamc uses itself; take another, "
            f"such as {prefix}_1"
        )
