#pragma once

namespace kerf::wire {

// Silences the log of Protocol Buffers; to be called once, by main(). The library writes a line to stderr for each
// string that is not UTF-8. Any client can send such strings, and the parser's error says enough.
void discard_protobuf_log();

}  // namespace kerf::wire
