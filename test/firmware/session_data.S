/* The recorded session, as constants. SEGCAL_SESSION is the file's path. */
#if defined(__arm__)
  .syntax unified
#endif
  .section .rodata.session, "a"
  .balign 8
  .global session_data
session_data:
  .incbin SEGCAL_SESSION
  .global session_data_end
session_data_end:
  .section .note.GNU-stack, ""
