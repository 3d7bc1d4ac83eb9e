/* An example of @NAME@ on a board: write the functions of board.h for yours. */

#include "board.h"

static struct @NAME@ controller;   /* no memory is allocated; there can be several */

int main(void)
{
    struct @NAME@_inputs inputs;
    struct @NAME@_outputs outputs;
    @NAME@_init(&controller);
    board_begin(&controller);   /* here parameters can be set, controller.block... */
    int32_t status = @NAME@_start(&controller);
    while (status == 0 && board_read(&inputs)) {
        status = @NAME@_sample(&controller, &inputs, &outputs);
        if (status == 0) {   /* else there are no outputs, or those of a sample before */
            board_write(&outputs);
        }
    }
    board_end(status);
    return status != 0;
}
