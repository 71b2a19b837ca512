#pragma once

namespace kerf::wire {

// Protocol Buffers write a line to stderr for each string that is no UTF-8, which anybody on the network can send; the
// parser's refusal says enough. To be called once, by main().
void discard_protobuf_log();

}  // namespace kerf::wire
