import { BufferAttribute, BufferGeometry, DoubleSide, Mesh, MeshStandardMaterial } from 'three';
import { vertexNormals } from '../geometry/normals';
import type { SheetArrays } from '../stream/sheet_copy';

export type MeshFormat = 'obj' | 'glb';

export interface MeshFile {
  content: string | ArrayBuffer;
  mediaType: string;
}

/**
 * Copies the shown sheet to a geometry: positions, normals, and material positions (m) as texture coordinates. Vertices
 * keep their numbers; slots without material are left out.
 */
export function sheetGeometry(sheet: SheetArrays): BufferGeometry {
  const { numVertices, numSlots, triangles } = sheet;
  const positions = sheet.positions.slice(0, 3 * numVertices);
  const normals = new Float32Array(3 * numVertices);
  vertexNormals(positions, numVertices, triangles, numSlots, normals);
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(positions, 3));
  geometry.setAttribute('normal', new BufferAttribute(normals, 3));
  geometry.setAttribute('uv', new BufferAttribute(sheet.materialPositions.slice(0, 2 * numVertices), 2));
  geometry.setIndex(new BufferAttribute(Uint32Array.from(triangles.subarray(0, 3 * numSlots).filter((v) => v >= 0)), 1));
  return geometry;
}

/**
 * Makes a mesh file. OBJ has z up, so that `kerf sheet create --obj` can read it. GLB is glTF 2.0 in one file, turned
 * to y up as glTF requires.
 * @param name  name of the object in the file
 */
export async function meshFile(sheet: SheetArrays, name: string, format: MeshFormat): Promise<MeshFile> {
  const geometry = sheetGeometry(sheet);
  const material = new MeshStandardMaterial({ name: 'cloth', color: 0xd8d0bc, roughness: 0.86, side: DoubleSide });
  const mesh = new Mesh(geometry, material);
  mesh.name = name;
  // The exporters are loaded only when needed.
  if (format === 'obj') {
    const { OBJExporter } = await import('three/addons/exporters/OBJExporter.js');
    return { content: new OBJExporter().parse(mesh), mediaType: 'model/obj' };
  }
  mesh.rotation.x = -Math.PI / 2;
  const { GLTFExporter } = await import('three/addons/exporters/GLTFExporter.js');
  const content = (await new GLTFExporter().parseAsync(mesh, { binary: true })) as ArrayBuffer;
  return { content, mediaType: 'model/gltf-binary' };
}
