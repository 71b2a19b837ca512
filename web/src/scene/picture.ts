/**
 * A PNG of layers, the lowest first, over the page's sky.
 * @param width   pixels
 * @param height  pixels
 */
export async function pictureOf(layers: readonly CanvasImageSource[], width: number, height: number): Promise<Blob> {
  const canvas = document.createElement('canvas');
  canvas.width = width;
  canvas.height = height;
  const context = canvas.getContext('2d')!;
  const style = getComputedStyle(document.documentElement);
  const sky = context.createLinearGradient(0, 0, 0, height);
  sky.addColorStop(0, style.getPropertyValue('--sky-top'));
  sky.addColorStop(1, style.getPropertyValue('--sky-bottom'));
  context.fillStyle = sky;
  context.fillRect(0, 0, width, height);
  for (const layer of layers) context.drawImage(layer, 0, 0, width, height);
  const blob = await new Promise<Blob | null>((resolve) => canvas.toBlob(resolve, 'image/png'));
  if (!blob) throw new Error(`the browser makes no picture of ${width} x ${height} pixels`);
  return blob;
}
