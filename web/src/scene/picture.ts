/**
 * Returns a PNG of the drawn canvas over the page's sky.
 * @param drawOver  draws what lies over the picture
 */
export async function pictureOf(
  drawn: HTMLCanvasElement,
  drawOver: (context: CanvasRenderingContext2D) => void,
): Promise<Blob> {
  const { width, height } = drawn;
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
  context.drawImage(drawn, 0, 0);
  drawOver(context);
  const blob = await new Promise<Blob | null>((resolve) => canvas.toBlob(resolve, 'image/png'));
  if (!blob) throw new Error(`the browser cannot make a picture of ${width} x ${height} pixels`);
  return blob;
}
