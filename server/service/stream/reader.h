#pragma once

#include "server/core/sheet/snapshot.h"
#include "server/service/wire/stream_codec.h"

namespace kerf::stream {

// Receives the signals of a Channel for one stream. The channel keeps no reader alive.
class Reader {
 public:
  virtual ~Reader() = default;

  // Signals a newer snapshot. Called on the sheet's strand, with no lock of the channel held; must not wait for
  // encoding.
  virtual void wake() = 0;
  // Adds to Snapshot::measured what the reader wants to have measured on the sheet for its next frame. Called on the
  // sheet's strand, before wake(), with no lock of the channel held.
  virtual void measure(const sheet::Sheet& /*sheet*/, sheet::Snapshot& /*snapshot*/) {}
  // Signals the end. The channel makes no call after this one.
  virtual void end(wire::EndReason reason) = 0;
  // Stops the calls of the channel, though one may still be in progress. Idempotent.
  virtual void leave() = 0;
};

}  // namespace kerf::stream
