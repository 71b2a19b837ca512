import type { FromImages, ToImages } from './image_messages';
import { ImageService } from './image_service';
import { openDecoder } from './picture_decoder';
import type { Port } from './watch_messages';

new ImageService(self as unknown as Port<FromImages, ToImages>, openDecoder);
