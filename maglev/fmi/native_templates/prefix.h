/* Names of @NAME@ that the linker sees, so that it can be linked into one program with other FMUs (FMI 2.0.5, 2.1.1).
 *
 * The functions of FMI get the prefix from HEADER@. A shared library exports them without: its compiler is to
 * define @FMI@_OVERRIDE_FUNCTION_PREFIX. */

#ifndef PREFIX_H
#define PREFIX_H

#ifndef @FMI@_OVERRIDE_FUNCTION_PREFIX
#define @FMI@_FUNCTION_PREFIX @NAME@_
#endif

@NAMES@

#endif
