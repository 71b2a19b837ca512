import type { FromImages, ToImages } from './image_messages';
import { ImageService } from './image_service';
import { openDecoder } from './picture_decoder';
import type { FromReplay, ToReplay } from './replay_messages';
import { ReplayService } from './replay_service';
import type { Port } from './watch_messages';

// One program for two workers, because most of it is the same code for messages.
if (self.name === 'images') new ImageService(self as unknown as Port<FromImages, ToImages>, openDecoder);
else new ReplayService(self as unknown as Port<FromReplay, ToReplay>);
