#pragma once

#include "server/service/wire/stream_codec.h"

namespace kerf::stream {

// One stream that follows a Channel, whatever it makes of the snapshots. The channel keeps no reader alive.
class Reader {
 public:
  virtual ~Reader() = default;

  // There is a newer snapshot. On the sheet's strand, with no lock of the channel held: must not wait for any encoding.
  virtual void wake() = 0;
  // The last call of the channel.
  virtual void end(wire::EndReason reason) = 0;
  // No more calls of the channel, though one may still be under way. Idempotent.
  virtual void leave() = 0;
};

}  // namespace kerf::stream
