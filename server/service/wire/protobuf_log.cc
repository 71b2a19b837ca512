#include "server/service/wire/protobuf_log.h"

#include <google/protobuf/stubs/logging.h>

namespace kerf::wire {

void discard_protobuf_log() {
  google::protobuf::SetLogHandler(nullptr);
}

}  // namespace kerf::wire
