// SPDX-License-Identifier: MIT
#pragma once

namespace mscomp {

/// Makes the process sound before anything else happens in it; the first call in main.
/// * Where standard input, output or error is closed, the next file opened would take its place,
/// and
///   what is meant for the terminal would go into it: they are opened onto nothing, in a way in
///   which every use fails as it would have failed before.
/// * A reader that is gone and a file that may not grow are failures of writing, not the end.
/// * Libraries that read their settings before main get them by one new start: OpenMP threads with
///   nothing to do soon sleep instead of keeping a processor busy, which on a shared machine stops
///   everybody; OpenBLAS makes no threads, whose memory it would wait for without end where it is
///   limited. Settings of the user's own stay. Where the process was started by another program (a
///   loader, valgrind, an emulator), which a new start would run instead, it goes on as it is.
void prepare_process(char** argv);

}  // namespace mscomp
