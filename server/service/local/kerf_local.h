#pragma once

#include <stddef.h>  // NOLINT(modernize-deprecated-headers): as C has them
#include <stdint.h>  // NOLINT(modernize-deprecated-headers)

// The C interface of kerf::local::LocalServer, for languages that load a shared library: libkerf_local.so. Messages are
// bytes of Protocol Buffers. Functions that fail return a google.rpc.Status as bytes; its code is the gRPC status code.
// Without the memory for it they return code 8, RESOURCE_EXHAUSTED, and no bytes: `data` is null.
// NOLINTBEGIN(modernize-use-using, readability-identifier-naming): names and types as C has them.
#ifdef __cplusplus
extern "C" {
#endif

typedef struct kerf_local kerf_local;

// Bytes that the caller frees by kerf_local_free().
typedef struct kerf_local_bytes {
  void* data;
  size_t size;
} kerf_local_bytes;

// Starts a server. `workers`: 1..256, 0: one for each processor. `render`: other than 0: it draws pictures. Returns
// null if it fails, and then a google.rpc.Status in `failure`.
kerf_local* kerf_local_start(int32_t workers, int32_t render, kerf_local_bytes* failure);
// Ends it. No call may be in progress.
void kerf_local_stop(kerf_local* server);

// Calls a unary RPC by its path, "/kerf.v1.SheetService/StepSheets". `time_limit_s`: seconds; below 0: none. Returns 0
// and the response in `answer`, or a gRPC status code and a google.rpc.Status. Callable from any thread.
int32_t kerf_local_call(kerf_local* server, const char* path, const void* request, size_t request_size,
                        double time_limit_s, kerf_local_bytes* answer);
// Makes a sheet of a mesh file. `start`: a kerf.v1.SheetUpload. Otherwise as kerf_local_call().
int32_t kerf_local_upload_sheet(kerf_local* server, const void* start, size_t start_size, const void* file,
                                size_t file_size, double time_limit_s, kerf_local_bytes* answer);
void kerf_local_free(kerf_local_bytes bytes);

#ifdef __cplusplus
}  // extern "C"
#endif
// NOLINTEND(modernize-use-using, readability-identifier-naming)
