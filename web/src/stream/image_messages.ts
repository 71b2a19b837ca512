import type { ImageCodec } from '../gen/kerf/v1/render_pb';
import type { ConnectionState } from './connection';
import type { ImageView, Refusal, ShownPicture } from './image_watch';
import type { Pace } from './watch';

// Messages between the page and the worker that holds its stream of pictures. `id` numbers the page's streams; messages
// about an earlier stream are ignored.

export type ToImages =
  | { kind: 'start'; id: number; url: string; name: string; codec: ImageCodec; view: ImageView; pace: Pace }
  | { kind: 'view'; id: number; view: ImageView }
  | { kind: 'pace'; id: number; pace: Pace }
  | { kind: 'acknowledge'; id: number; sequence: number }
  | { kind: 'retry'; id: number }
  | { kind: 'close'; id: number };

export type FromImages =
  | { kind: 'state'; id: number; state: ConnectionState; detail: string }
  | { kind: 'picture'; id: number; shown: ShownPicture }
  | { kind: 'refused'; id: number; refusal: Refusal; message: string };
