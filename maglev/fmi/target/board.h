/* Functions of a board that the example needs. */

#ifndef BOARD_H
#define BOARD_H

#include "@NAME@.h"

/* Clock, converters, timer; and parameters that are not to be those of @NAME@_init. */
void board_begin(struct @NAME@ *controller);

/* Wait for the next sample, @PERIOD@ s after the one before, and read references and encoders. Return false if there is
 * no sample. */
bool board_read(struct @NAME@_inputs *inputs);

/* Command the currents. */
void board_write(const struct @NAME@_outputs *outputs);

/* Without a sample more, or with one that was refused: no current. */
void board_end(int32_t status);

#endif
